#include "view/page_about.hpp"

#include <fmt/format.h>

#include <oncollide/base/text/printable.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/runs/report.hpp>

namespace oncollide::tools {
namespace {

std::string accuracy_text(const Settings& s, double metres)
{
    if (s.depth) return fmt::format("depth {} of the sphere-trees", *s.depth);
    if (s.max_error) return fmt::format("{:g} m", *s.max_error * metres);
    return "1 % of the smaller body";
}

} // namespace

nlohmann::json page_about(const Pipeline& pipeline, double metres, const std::string& results)
{
    const Settings& s = pipeline.settings();
    nlohmann::json rows = nlohmann::json::array();
    rows.push_back({"Accuracy (max_error)", accuracy_text(s, metres)});
    rows.push_back({"Decided exactly (--exact)", name_of(exact_level(s))});
    rows.push_back({"Clearance", fmt::format("{:g} m", s.clearance * metres)});
    rows.push_back({"Inside of meshes (--mode)", s.mode == Mode::solid ? "included: solid" : "not included: surface"});
    rows.push_back({"Refined with", wants_obbs(s) ? "oriented boxes (OBB trees)" : "sphere-trees (OCST)"});
    if (results.empty()) {
        rows.push_back({"Threads", fmt::format("{}", thread_count(s))});
        const WorldInfo info = pipeline.inspect();
        rows.push_back({"Backend", info.backend});
        if (!info.backend_note.empty()) rows.push_back({"Note", info.backend_note});
    } else {
        rows.push_back({"Results", printable(results)});
    }
    rows.push_back({"Result hash", fmt::format("{:016x}", pipeline.hash())});
    rows.push_back({"oncollide", version});
    return rows;
}

} // namespace oncollide::tools
