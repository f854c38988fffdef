#include "bench/scenes/scene_race.hpp"

#include <optional>

#include "truth/scene_truth.hpp"

#include <oncollide/pipeline/results.hpp>
#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide::tools {
namespace {

/// FCL judges. Where it and oncollide differ, the truth decides: libccd, which FCL uses for shapes, stops within 1e-6.
Comparison compare(const Scene& scene, const FrameView& frame, const Settings& settings, const FclFrame& fcl)
{
    Comparison result;
    result.pairs = frame.pairs.size(), result.fcl_colliding = fcl.colliding.size();
    const auto truly_collide = [&](BodyPair pair, bool perhaps) {
        const auto model = [&](std::uint32_t body) -> const GeometryData& {
            return scene.geometries[index(scene.geometry[body])].data;
        };
        const bool solid = settings.mode == Mode::solid;
        const TruthModel a(model(pair.a), solid), b(model(pair.b), solid);
        const PairTruth truth = truth_of(a, scene.poses[pair.a], b, scene.poses[pair.b],
                                         {.kinds = false, .deep = false, .distance = false});
        return truth.collide || (perhaps && (truth.open || truth.enclosed));
    };
    const auto miss = [&](BodyPair pair) {
        if (!truly_collide(pair, false)) {
            ++result.missed_by_rounding;
            return;
        }
        ++result.missed;
        if (result.first_missed.empty())
            result.first_missed = fmt::format("frame {}: {}", frame.frame, names_of(scene, pair));
    };
    auto theirs = fcl.colliding.begin();
    for (const PairResult& ours : frame.pairs) { // both lists are sorted
        const BodyPair pair{index(ours.a), index(ours.b)};
        while (theirs != fcl.colliding.end() && *theirs < pair) miss(*theirs++);
        const bool collides = theirs != fcl.colliding.end() && *theirs == pair;
        theirs += collides;
        const bool left_over = ours.verdict != Verdict::separate, colliding = ours.verdict == Verdict::colliding;
        result.left_over += left_over, result.colliding += colliding;
        result.undecided += ours.verdict == Verdict::undecided;
        result.false_positives += left_over && !collides;
        const bool ignored = settings.ignore_touching && ours.kind == ContactKind::touching;
        if (collides && !left_over && !ignored) miss(pair);
        if (exact_level(settings) != ExactLevel::off && colliding && !collides)
            result.wrong_exact += !truly_collide(pair, true);
    }
    while (theirs != fcl.colliding.end()) miss(*theirs++);
    return result;
}

class SceneRace {
public:
    SceneRace(const CompareOptions& options, const Settings& settings, Scene& scene)
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
            take_turns(2, std::size_t(run) + 1, [&](std::size_t fcl) {
                if (fcl && with_fcl_)
                    runs_.fcl_cold.push_back(least_ms(1, [&] { FclWorld(scene_, octrees_).step(options_.contacts); }));
                if (!fcl && with_ours_)
                    runs_.our_cold.push_back(least_ms(1, [&] {
                        Pipeline pipeline(scene_, settings_);
                        const FrameView view = pipeline.step(scene_);
                        Lists<Contact> contacts;
                        if (options_.contacts) pipeline.world().pairs().contacts(colliding(view), contacts);
                    }));
            });
        }
    }

    void play(int repeat)
    {
        Mover mover;
        mover.move(scene_, 0), mover.move(scene_, runs_.first);
        std::optional<FclWorld> world;
        std::optional<Pipeline> pipeline;
        Lists<Contact> contacts;
        if (with_fcl_) world.emplace(scene_, octrees_), runs_.fcl_bytes = world->model_bytes();
        if (with_ours_) pipeline.emplace(scene_, settings_), runs_.backend = pipeline->inspect().backend;
        if (pipeline && runs_.first) WorldAccess::continue_from(pipeline->world(), std::uint32_t(runs_.first), 0);
        for (int frame = runs_.first; frame < runs_.first + int(runs_.rows.size()); ++frame) {
            mover.move(scene_, frame);
            SceneRow& row = runs_.rows[static_cast<std::size_t>(frame - runs_.first)];
            FclFrame theirs;
            std::optional<FrameView> ours;
            take_turns(2, std::size_t(frame + repeat) + 1, [&](std::size_t fcl) {
                if (fcl && world) theirs = world->step(options_.contacts);
                if (fcl || !pipeline) return;
                ours.emplace(pipeline->step(scene_));
                if (options_.contacts) find_contacts(row, pipeline->world(), contacts, *ours);
            });
            if (world) take(row, theirs);
            if (ours) take(row, *ours);
            if (world && ours) row.counts = compare(scene_, *ours, settings_, theirs);
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
    void find_contacts(SceneRow& row, const World& world, Lists<Contact>& contacts, FrameView& frame) const
    {
        const Clock::time_point from = Clock::now();
        world.pairs().contacts(colliding(frame), contacts);
        row.our_contacts = contacts.items.size();
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

Comparison& Comparison::operator+=(const Comparison& o)
{
    pairs += o.pairs, left_over += o.left_over, undecided += o.undecided, colliding += o.colliding;
    fcl_colliding += o.fcl_colliding, false_positives += o.false_positives, missed += o.missed;
    missed_by_rounding += o.missed_by_rounding, wrong_exact += o.wrong_exact;
    if (first_missed.empty()) first_missed = o.first_missed;
    return *this;
}

SceneRuns race(const CompareOptions& options, const Settings& settings, Scene& scene)
{
    return SceneRace(options, settings, scene).run();
}

} // namespace oncollide::tools
