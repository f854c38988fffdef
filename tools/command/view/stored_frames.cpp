#include "view/stored_frames.hpp"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/result_hash.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/world/stage.hpp>
#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide::tools {
namespace {

StoredRun run_of(const std::string& name, const ResultsHeader& header, const std::string& scene,
                 const std::string& data)
{
    StoredRun run = stored_run(name, header);
    if (!data.empty()) run.scene.data = data;
    if (!scene.empty()) {
        run.scene.scene = scene;
        if (is_scene_file(scene)) run.scene.bodies.reset(), run.scene.seed.reset();
    }
    if (run.scene.scene.empty())
        usage(fmt::format(
            "{0}: its scene came from standard input; give its file: oncollide view {0} SCENE.json -o ...", name));
    return run;
}

Scene scene_of(const std::string& name, const StoredRun& run)
{
    try {
        return open_scene(run.scene);
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::no_input) throw;
        throw Error(ErrorKind::no_input, fmt::format("{}; {} was made from that scene: if the scene has moved, give "
                                                     "its file after the results",
                                                     error.what(), name));
    }
}

/// If bodies move between frames, they start from the frame before the first one.
Scene scene_before(const std::string& name, const StoredRun& run, std::span<const FrameRow> frames)
{
    Scene scene = scene_of(name, run);
    if (run.continuous && !frames.empty() && frames.front().frame > 0)
        Mover().move(scene, static_cast<int>(frames.front().frame) - 1);
    return scene;
}

Settings without_narrow_phase(Settings settings, int threads)
{
    settings.threads = threads, settings.backend = BackendKind::cpu;
    settings.skip.insert(StageId::refine), settings.skip.insert(StageId::exact);
    return settings;
}

} // namespace

StoredFrames::StoredFrames(const std::string& results, const std::string& scene, const std::string& data, int threads)
    : name_(results), stored_(open_pairs(results)), run_(run_of(results, stored_.header(), scene, data)),
      scene_(scene_before(results, run_, stored_.frames())),
      pipeline_(scene_, without_narrow_phase(run_.settings, threads))
{
    if (scene_.size() != stored_.header().bodies)
        refuse_scene(
            fmt::format("the scene has {} bodies, the results have {}", scene_.size(), stored_.header().bodies));
    if (const std::string other = stored_.unlike(scene_.names); !other.empty())
        refuse_scene(fmt::format("the scene has no body '{}' at that number", other));
    if (stored_.frames().back().frame >= std::uint64_t(scene_.frames))
        refuse_scene(fmt::format("the scene has frames 0 to {}, the results end with frame {}", scene_.frames - 1,
                                 stored_.frames().back().frame));
    played_ = first() - 1;
}

void StoredFrames::refuse_scene(const std::string& why) const
{
    throw Error(ErrorKind::bad_data,
                fmt::format("{}: does not fit {} in its present state: {}", name_, run_.scene.scene, why));
}

FrameView StoredFrames::step(int frame)
{
    if (run_.continuous && frame > 0 && played_ != frame - 1) {
        pipeline_.set_continuous(false);
        mover_.move(scene_, frame - 1);
        pipeline_.step(scene_);
    }
    WorldAccess::continue_from(pipeline_.world(), std::uint32_t(frame), 0);
    pipeline_.set_continuous(run_.continuous && frame > 0);
    mover_.move(scene_, played_ = frame);
    return pipeline_.step(scene_);
}

FrameView StoredFrames::play(int frame)
{
    const FrameRow& row = stored_.frames()[std::size_t(frame - first())];
    const FrameView played = step(frame);
    WorldAccess::continue_from(pipeline_.world(), std::uint32_t(frame) + 1, row.chain);
    decide(row, played.pairs);
    count(row, played.stages);
    return {.frame = row.frame,
            .ms = row.ms,
            .pairs = results_,
            .began = played.began,
            .ended = played.ended,
            .stages = stages_,
            .totals = played.totals,
            .delimitation = played.delimitation,
            .trees = played.trees,
            .rounds = played.rounds,
            .hash = row.hash,
            .sweeps = sweeps_};
}

/// Both are sorted by their bodies. Candidates that are not in the file were separate.
void StoredFrames::decide(const FrameRow& row, std::span<const PairResult> candidates)
{
    stored_.read(row, rows_), stored_.read(row, sweep_rows_);
    sweeps_.clear();
    results_.assign(candidates.begin(), candidates.end());
    std::uint64_t hash = 0;
    auto next = rows_.begin();
    for (PairResult& pair : results_) {
        if (next == rows_.end() || next->a != pair.a.slot || next->b != pair.b.slot) {
            pair.verdict = Verdict::separate, pair.stage = StageId::refine, pair.kind = {}, pair.bound = 0;
            continue;
        }
        if (next->verdict > std::uint8_t(Verdict::undecided) || next->stage >= pipeline_.stages().size() ||
            next->kind > std::uint8_t(ContactKind::enclosed))
            break;
        pair.verdict = Verdict(next->verdict), pair.stage = StageId(next->stage), pair.kind = ContactKind(next->kind);
        pair.bound = next->bound;
        mix(hash, pair, wants_kinds(run_.settings));
        const SweepRow* const sweep = sweep_rows_.empty() ? nullptr : &sweep_rows_[std::size_t(next - rows_.begin())];
        if (sweep && !std::isnan(sweep->clear_until)) {
            add_sweep(*sweep, std::size_t(&pair - results_.data()));
            mix(hash, pair, {sweep->clear_until, sweep->contact_by});
        }
        ++next;
    }
    if (next != rows_.end())
        refuse_scene(fmt::format("in frame {} the results have a pair of bodies {} and {}, whose boxes are "
                                 "apart",
                                 row.frame, next->a, next->b));
    if (hash != row.hash)
        refuse(name_, fmt::format("the pairs of frame {} are damaged: their hash differs", row.frame));
}

/// The stored parts of the sweep of a pair in results_.
void StoredFrames::add_sweep(const SweepRow& row, std::size_t pair)
{
    PairSweep& sweep = sweeps_.emplace_back();
    sweep.pair = static_cast<std::uint32_t>(pair);
    sweep.verdict = results_[pair].verdict, sweep.kind = results_[pair].kind;
    sweep.clear_until = row.clear_until, sweep.contact_by = row.contact_by, sweep.gap = row.gap;
    sweep.separating = row.separating != 0;
    sweep.contact.a = row.triangle_a, sweep.contact.b = row.triangle_b;
    sweep.contact.ends[0] = sweep.contact.ends[1] = Eigen::Vector3d::Map(row.point.data());
    if (!std::isnan(row.normal[0])) sweep.normal = Eigen::Vector3d::Map(row.normal.data());
}

/// Input and output counts of each stage come from the file; the reason for skipping one follows from settings and
/// poses.
void StoredFrames::count(const FrameRow& row, std::span<const StageStats> stages)
{
    stages_.assign(stages.begin(), stages.end());
    for (std::size_t k = 0; k < stages_.size(); ++k) {
        StageStats& stage = stages_[k];
        const StageRow& stored = row.stages[k];
        stage.in = stored.in, stage.out = stored.out, stage.undecided = stored.undecided, stage.cpu_ms = stored.ms;
        const auto id = static_cast<StageId>(k);
        if (id < StageId::refine) continue;
        const bool requested = run_.settings.skip.contains(id);
        const bool off = id == StageId::exact && exact_level(run_.settings) == ExactLevel::off;
        const bool idle = id == StageId::refine && results_.empty();
        stage.note = requested ? by_request : off ? "off" : idle ? no_candidates : "";
        stage.skipped = !stage.note.empty();
    }
    constexpr auto broad = static_cast<std::size_t>(StageId::broad);
    if (row.stages[broad].out != results_.size())
        refuse_scene(fmt::format("in frame {} the boxes of {} pairs overlap; in the run {} did", row.frame,
                                 results_.size(), row.stages[broad].out));
}

} // namespace oncollide::tools
