#include "bench/paper/gpu_report.hpp"

#include <oncollide/base/error.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/base/threads/parallel.hpp>

#include "cli/build_info.hpp"
#include "cli/standard_output.hpp"
#include "cli/system.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

std::string shown(const GpuReport::Value& value)
{
    struct Show {
        std::string operator()(std::uint64_t n) const { return grouped(n); }
        std::string operator()(double x) const { return plain_measure(x, 4); }
        std::string operator()(const std::string& text) const { return text; }
        std::string operator()(bool b) const { return b ? "yes" : "NO"; }
    };
    return std::visit(Show{}, value);
}

} // namespace

void GpuReport::begin(const std::string& name, const std::string& title)
{
    parts_.push_back({name, title, {}, {}});
    say("\n{}: {}\n", name, title);
}

void GpuReport::row(const std::string& what, const std::string& backend, const Values& values)
{
    std::vector<Row>& rows = parts_.back().rows;
    if (rows.empty()) {
        say("{:<26}{:<24}", "", "");
        for (const auto& [name, value] : values) say("{:>18}", name);
        say("\n");
    }
    rows.push_back({what, backend, values});
    say("{:<26}{:<24}", what, backend);
    for (const auto& [name, value] : values) say("{:>18}", shown(value));
    say("\n");
    flush_stdout();
}

void GpuReport::leave_out(const std::string& why)
{
    parts_.back().left_out.push_back(why);
    say("left out: {}\n", why);
}

void GpuReport::write_json(TextSink& out, const GpuInfo& gpu,
                           const std::vector<std::pair<std::string, std::int64_t>>& limits, const std::string& sizes,
                           double limit_s, double seconds) const
{
    JsonWriter json(out);
    json.begin_object(), json.schema("oncollide.bench_gpu", 1);
    json.line(1), json.key("machine");
    json.object("version", version, "build", build_text(), "processor", processor_name(), "threads",
                hardware_threads());
    json.line(1), json.key("gpu"), json.begin_object();
    json.members("renderer", gpu.renderer, "vendor", gpu.vendor, "version", gpu.version, "platform", gpu.platform,
                 "software", gpu.software, "context_ms", gpu.start_ms);
    json.key("limits"), json.begin_object();
    for (const auto& [name, value] : limits) json.members(name, value);
    json.end_object(), json.end_object();
    json.line(1), json.members("sizes", sizes, "limit_s", limit_s, "seconds", seconds);
    json.key("parts"), json.begin_array();
    for (const Part& part : parts_) {
        json.line(2), json.begin_object(), json.members("name", part.name, "title", part.title);
        json.key("left_out"), json.begin_array();
        for (const std::string& why : part.left_out) json.value(why);
        json.end_array(), json.key("rows"), json.begin_array();
        for (const Row& row : part.rows) {
            json.line(3), json.begin_object(), json.members("what", row.what, "backend", row.backend);
            for (const auto& [name, value] : row.values) {
                json.key(name);
                std::visit([&](const auto& v) { json.value(v); }, value);
            }
            json.end_object();
        }
        json.end_array(), json.end_object();
    }
    json.line(), json.end_array(), json.end_object();
    out.write("\n");
}

} // namespace oncollide::tools
