#include "bench/gpu/gpu_report.hpp"

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/parallel.hpp>

#include "cli/build_info.hpp"
#include "cli/system.hpp"
#include "common/text.hpp"

namespace oncollide::tools {

void GpuPart::leave_out(const std::string& why)
{
    left_out.push_back(why);
    say("left out: {}\n", why);
}

void GpuReport::commit()
{
    for (GpuPart& part : parts_) part.table.commit();
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
    for (const GpuPart& part : parts_) {
        json.line(2), json.begin_object(), json.members("name", part.name, "title", part.title);
        json.key("left_out"), json.begin_array();
        for (const std::string& why : part.left_out) json.value(why);
        json.end_array(), json.key("rows"), part.table.write(json, 3), json.end_object();
    }
    json.line(), json.end_array(), json.end_object();
    out.write("\n");
}

} // namespace oncollide::tools
