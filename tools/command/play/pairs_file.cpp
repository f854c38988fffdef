#include "play/pairs_file.hpp"

#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/settings_table.hpp>
#include <oncollide/pipeline/world/world_access.hpp>
#include <oncollide/runs/report.hpp>
#include <oncollide/runs/report_kept.hpp>

namespace oncollide::tools {
namespace {

using nlohmann::json;

/// The names of the values in a row.
ResultsHeader words(std::span<const std::string_view> stages)
{
    ResultsHeader header;
    for (int v = 0; v <= int(Verdict::undecided); ++v) header.verdicts.emplace_back(name_of(Verdict(v)));
    for (int k = 0; k <= int(ContactKind::enclosed); ++k) header.kinds.emplace_back(name_of(ContactKind(k)));
    header.stages.assign(stages.begin(), stages.end());
    return header;
}

template <class Value>
json optional_json(const std::optional<Value>& value)
{
    return value ? json(*value) : json();
}
template <class Value>
std::optional<Value> optional_from(const json& value)
{
    return value.is_null() ? std::nullopt : std::optional(value.get<Value>());
}

/// Paths are absolute: the results may be read from another folder.
std::string source_json(const SceneOptions& o)
{
    const auto placed = [](const std::string& path) {
        return json(path.empty() ? path : absolute_path(path).lexically_normal().string());
    };
    const json scene = o.scene == "-" ? json() : is_scene_file(o.scene) ? placed(o.scene) : json(o.scene);
    const json source{{"scene", scene},
                      {"bodies", optional_json(o.bodies)},
                      {"frames", optional_json(o.frames)},
                      {"seed", optional_json(o.seed)},
                      {"data", placed(o.data)},
                      {"pace", o.pace}};
    return source.dump(-1, ' ', false, json::error_handler_t::replace);
}

ResultsHeader header_of(const SceneOptions& source, const Scene& scene, const Pipeline& pipeline, bool separate)
{
    ResultsHeader header = words(pipeline.stages());
    header.version = std::string(version), header.scene = scene.name, header.bodies = scene.size();
    Settings settings = pipeline.settings(); // without settings that never change a result
    settings.threads = 1, settings.gpu = Settings{}.gpu;
    if (certified(settings)) settings.backend = BackendKind::cpu;
    const std::string run = settings_json(settings);
    TextInMemory text;
    JsonWriter json(text);
    json.begin_object();
    json.members("bodies", scene.size(), "pace", scene.pace, "separate", separate);
    if (pipeline.continuous()) json.members("continuous", true);
    if (!certified(settings)) json.members("certified", false);
    json.members("run", JsonText{run});
    json.end_object();
    header.sweeps = pipeline.continuous();
    header.settings = text.text();
    header.source = source_json(source);
    return header;
}

SweepRow row_of(const PairSweep* sweep)
{
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    SweepRow row{unknown, unknown, unknown, SweepRow::no_triangle, SweepRow::no_triangle, 0, {}, {}};
    row.point.fill(unknown), row.normal.fill(unknown);
    if (!sweep) return row;
    row.clear_until = sweep->clear_until, row.contact_by = sweep->contact_by, row.gap = sweep->gap;
    row.separating = sweep->separating;
    if (!sweep->normal.isZero(0)) Eigen::Vector3d::Map(row.normal.data()) = sweep->normal;
    if (!has_parts(*sweep)) return row;
    const auto triangle = [](const BodyPart& part) {
        return part.cell.side > 0 ? SweepRow::no_triangle : part.triangle;
    };
    row.triangle_a = triangle(sweep->contact.a), row.triangle_b = triangle(sweep->contact.b);
    Eigen::Vector3d::Map(row.point.data()) = sweep->contact.middle();
    return row;
}

} // namespace

PairsFile::PairsFile(const std::filesystem::path& path, const SceneOptions& source, const Scene& scene,
                     Pipeline& pipeline, int frame, bool separate)
    : pipeline_(pipeline), separate_(separate),
      file_(path, header_of(source, scene, pipeline, separate), scene.names, static_cast<std::uint64_t>(frame))
{
    if (frame) WorldAccess::continue_from(pipeline.world(), static_cast<std::uint32_t>(frame), file_.chain());
}

void PairsFile::add(const FrameView& frame)
{
    rows_.clear(), sweeps_.clear();
    SweepOfPair sweep_of(frame);
    for (std::size_t i = 0; i < frame.pairs.size(); ++i) {
        const PairResult& pair = frame.pairs[i];
        if (!separate_ && pair.verdict == Verdict::separate) continue;
        rows_.push_back({index(pair.a), index(pair.b), static_cast<std::uint8_t>(pair.verdict),
                         static_cast<std::uint8_t>(pair.stage), static_cast<std::uint8_t>(pair.kind), pair.bound,
                         pipeline_.world().pairs().max_error(pair.a, pair.b)});
        if (pipeline_.continuous()) sweeps_.push_back(row_of(sweep_of(i)));
    }
    FrameRow row{.frame = frame.frame,
                 .first = 0,
                 .pairs = 0,
                 .hash = frame.hash,
                 .chain = pipeline_.hash(),
                 .ms = frame.ms,
                 .stages = {}};
    std::ranges::transform(frame.stages, row.stages.begin(), [](const StageStats& s) {
        return StageRow{s.in, s.out, s.undecided, s.cpu_ms};
    });
    file_.add(rows_, row, sweeps_);
}

StoredResults open_pairs(const std::filesystem::path& path)
{
    check_readable(path);
    return {path, words(all_stage_names())};
}

StoredRun stored_run(const std::string& name, const ResultsHeader& header)
{
    if (header.version != version)
        throw Error(ErrorKind::usage, fmt::format("{}: was written by oncollide {}, this is {}; run the scene again",
                                                  name, header.version, version));
    try {
        const json settings = json::parse(header.settings), run = settings.at("run"),
                   source = json::parse(header.source);
        StoredRun stored{.scene = {},
                         .settings = {},
                         .separate = settings.at("separate"),
                         .continuous = settings.value("continuous", false)};
        Settings& s = stored.settings;
        set_results_settings(s, run);
        check(s);
        SceneOptions& scene = stored.scene;
        scene.scene = optional_from<std::string>(source.at("scene")).value_or("");
        scene.bodies = optional_from<int>(source.at("bodies"));
        scene.seed = optional_from<std::uint64_t>(source.at("seed"));
        scene.frames = optional_from<int>(source.at("frames"));
        scene.data = source.at("data"), scene.pace = source.at("pace"), scene.on_demand = true;
        return stored;
    } catch (const json::exception& error) {
        refuse(name, fmt::format("cannot read its attributes 'settings' and 'source': {}", error.what()));
    }
}

} // namespace oncollide::tools
