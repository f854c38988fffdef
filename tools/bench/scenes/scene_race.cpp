#include "bench/scenes/scene_race.hpp"

#include <optional>

#include "cli/shard.hpp"

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/results.hpp>

namespace oncollide::tools {
namespace {

class Race {
public:
    Race(const CompareOptions& options, const Settings& settings, Scene& scene)
        : options_(options), settings_(settings), scene_(scene), with_fcl_(options.only != "oncollide"),
          with_ours_(options.only != "fcl")
    {
    }

    SceneRuns run()
    {
        if (with_fcl_) octrees_ = FclWorld::octrees_of(scene_);
        const auto [begin, end] = shard_from(options_.shard).range(std::size_t(scene_.frames));
        runs_.first = int(begin);
        runs_.rows.resize(end - begin);
        measure_cold_starts();
        for (int repeat = 0; repeat < options_.repeats; ++repeat) play(repeat);
        return std::move(runs_);
    }

private:
    /// Measures from a scene in memory to the results of its first frame, each time in the initial state.
    void measure_cold_starts()
    {
        for (int run = 0; run < options_.cold_runs; ++run) {
            Mover mover;
            mover.move(scene_, 0), mover.move(scene_, runs_.first);
            for (const bool fcl : {run % 2 == 0, run % 2 != 0}) {
                if (!(fcl ? with_fcl_ : with_ours_)) continue;
                const Clock::time_point from = Clock::now();
                if (fcl) {
                    FclWorld world(scene_, octrees_);
                    world.step(options_.contacts);
                    runs_.fcl_cold.push_back(milliseconds_since(from));
                } else {
                    Pipeline pipeline(scene_, settings_);
                    const FrameView view = pipeline.step(scene_);
                    ContactLists contacts;
                    if (options_.contacts) pipeline.world().contacts(colliding(view), contacts);
                    runs_.our_cold.push_back(milliseconds_since(from));
                }
            }
        }
    }

    void play(int repeat)
    {
        Mover mover;
        mover.move(scene_, 0), mover.move(scene_, runs_.first);
        std::optional<FclWorld> world;
        std::optional<Pipeline> pipeline;
        ContactLists contacts;
        if (with_fcl_) world.emplace(scene_, octrees_), runs_.fcl_bytes = world->model_bytes();
        if (with_ours_) pipeline.emplace(scene_, settings_), runs_.backend = pipeline->inspect().backend;
        if (pipeline && runs_.first) pipeline->world().continue_from(std::uint32_t(runs_.first), 0);
        for (int frame = runs_.first; frame < runs_.first + int(runs_.rows.size()); ++frame) {
            mover.move(scene_, frame);
            SceneRow& row = runs_.rows[static_cast<std::size_t>(frame - runs_.first)];
            FclFrame theirs;
            std::optional<FrameView> ours;
            const bool fcl_first = (frame + repeat) % 2 == 0;
            for (const bool fcl : {fcl_first, !fcl_first}) {
                if (fcl && world) theirs = world->step(options_.contacts);
                if (!fcl && pipeline) {
                    ours.emplace(pipeline->step(scene_));
                    if (options_.contacts) find_contacts(row, pipeline->world(), contacts, *ours);
                }
            }
            if (world) take(row, theirs);
            if (ours) take(row, *ours);
            if (world && ours) row.counts = compare(scene_, *ours, settings_, theirs, *world);
        }
        if (!pipeline) return;
        if (repeat > 0 && pipeline->hash() != runs_.hash)
            throw Error(ErrorKind::internal, fmt::format("two runs of one scene differ: hash {:016x} and {:016x}",
                                                         runs_.hash, pipeline->hash()));
        runs_.hash = pipeline->hash();
    }

    static std::vector<PairOfBodies> colliding(const FrameView& frame)
    {
        std::vector<PairOfBodies> pairs;
        for (const PairResult& pair : frame.pairs)
            if (pair.verdict == Verdict::colliding) pairs.push_back({pair.a, pair.b});
        return pairs;
    }

    /// The time counts as time of the exact level.
    void find_contacts(SceneRow& row, const World& world, ContactLists& contacts, FrameView& frame) const
    {
        const Clock::time_point from = Clock::now();
        world.contacts(colliding(frame), contacts);
        row.our_contacts = contacts.contacts.size();
        row.contacts_ms = milliseconds_since(from);
        frame.ms += row.contacts_ms;
    }

    static void take(SceneRow& row, const FclFrame& frame)
    {
        row.fcl_contacts = frame.contacts;
        row.fcl_candidates = frame.candidates, row.counts.fcl_colliding = frame.colliding.size();
        if (frame.ms() >= row.fcl_ms) return;
        row.fcl_ms = frame.ms();
        row.fcl_parts = {frame.transforms_ms, frame.update_ms, frame.pairs_ms, frame.narrow_ms};
    }

    void take(SceneRow& row, const FrameView& frame)
    {
        row.hash = frame.hash, row.trees = frame.trees, row.counts = {};
        row.counts.pairs = frame.pairs.size();
        row.regions = regions_text(frame.delimitation), row.left = frame.stages[1].out;
        for (const PairResult& pair : frame.pairs) {
            row.counts.left_over += pair.verdict != Verdict::separate;
            row.counts.colliding += pair.verdict == Verdict::colliding;
            row.counts.undecided += pair.verdict == Verdict::undecided;
        }
        runs_.our_bytes = std::max(runs_.our_bytes, frame.trees.bytes);
        if (frame.ms >= row.our_ms) return;
        row.our_ms = frame.ms;
        row.gpu_ms = frame.stages[3].gpu_ms, row.wait_ms = frame.stages[3].wait_ms;
        for (std::size_t i = 0; i < stage_count; ++i) row.our_parts[i] = frame.stages[i].cpu_ms;
    }

    const CompareOptions& options_;
    const Settings& settings_;
    Scene& scene_;
    const bool with_fcl_, with_ours_;
    FclWorld::Octrees octrees_;
    SceneRuns runs_;
};

} // namespace

SceneRuns race(const CompareOptions& options, const Settings& settings, Scene& scene)
{
    return Race(options, settings, scene).run();
}

} // namespace oncollide::tools
