#include <oncollide/pipeline/world/sweep_pairs.hpp>

#include <algorithm>
#include <optional>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/hulls/outer_hull.hpp>

namespace oncollide {

SweepResult sweep_pair(ModelStore& models, PairWorker& worker, const SweepTask& task)
{
    try {
        return models.with_room([&] { return tests_for(task.a->kind(), task.b->kind()).advance(worker, task); });
    } catch (const ChunkFault& fault) {
        models.note(fault.what());
        return {};
    }
}

/// Upper bound on how far any point of the body moves on its way.
double SweepPairs::moved(const BodyTable& bodies, std::uint32_t slot)
{
    if (moved_[slot] >= 0) return moved_[slot];
    const RigidMotion* const motion = bodies.motion(slot);
    return moved_[slot] = motion ? bodies.model(slot).bounds().motion(motion->pose(0), *motion) : 0;
}

/// True if the hulls are apart at both ends of the ways, in one direction, by more than any point leaves its straight
/// line between them.
bool SweepPairs::hulls_stay_apart(const BodyTable& bodies, const PairMemory& memory, const PairResult& last,
                                  double needed)
{
    Eigen::Isometry3d starts[2];
    double bends = 0x1p-20 * farthest_apart(bodies.boxes()[last.a.slot], bodies.boxes()[last.b.slot]);
    for (const int side : {0, 1}) {
        const std::uint32_t slot = side ? last.b.slot : last.a.slot;
        const RigidMotion* const motion = bodies.motion(slot);
        starts[side] = motion ? motion->pose(0) : bodies.pose(slot);
        if (!motion) continue;
        const RigidMotion::State state = motion->at(0);
        if (state.key < 1) return false;
        bends += bodies.model(slot).bounds().bulge(state, 1);
    }
    const OuterHull *const a = bodies.model(last.a.slot).hull(), *const b = bodies.model(last.b.slot).hull();
    if (!a || !b || !(last.bound * (1 - 0x1p-18) - bends > needed)) return false;
    const Eigen::Vector3d across = bodies.pose(last.a.slot).linear() * memory.across.cast<double>().normalized();
    const Eigen::Vector3d in_a = starts[0].linear().transpose() * across;
    return gap_along(*a, *b, RelativePose(starts[0], starts[1]), in_a) - bends > needed;
}

bool SweepPairs::apart_on_the_way(const BodyTable& bodies, Frame& frame, std::uint32_t pair)
{
    const PairResult& last = frame.results[pair];
    if (last.verdict != Verdict::separate || last.kind == ContactKind::touching) return false;
    const PairMemory& memory = frame.cache[pair];
    const std::uint32_t a = last.a.slot, b = last.b.slot;
    const double travel = bodies.travel(a) + bodies.travel(b), gap = last.bound * (1 - 0x1p-18),
                 needed = frame.settings.clearance * (1 + 0x1p-16);
    // The gap of an earlier frame is less the motion of this one.
    if (memory.walked_at < travel && memory.gap(travel) > 0 && gap > needed) return true;
    if (gap - moved(bodies, a) - moved(bodies, b) > needed) return true;
    return memory.by_hulls && memory.walked_at == travel && hulls_stay_apart(bodies, memory, last, needed);
}

void SweepPairs::run(const BodyTable& bodies, Frame& frame, StageStats& stats)
{
    frame.sweeps.clear(), open_.clear();
    moved_.assign(bodies.slots(), -1);
    auto swept = frame.swept.begin();
    for (std::uint32_t i = 0; i < frame.pairs.size(); ++i) {
        if (!bodies.motion(frame.pairs[i].a) && !bodies.motion(frame.pairs[i].b)) continue;
        PairSweep& sweep = frame.sweeps.emplace_back();
        sweep.pair = i;
        const bool met = swept != frame.swept.end() && *swept == i;
        swept += met;
        if (!met && frame.settings.coherence && apart_on_the_way(bodies, frame, i))
            sweep.verdict = Verdict::separate, sweep.clear_until = sweep.grazes_until = 1;
        else
            open_.push_back({static_cast<std::uint32_t>(frame.sweeps.size() - 1), met});
    }
    sweep(bodies, frame);
    for (const Open& open : open_)
        if (open.met) frame.cache[frame.sweeps[open.sweep].pair].meets = frame.sweeps[open.sweep].contact_by == 0;
    report(bodies, frame, stats);
}

/// Sets the results of the pairs, and the counts of pairs as if these results were of the last stage.
void SweepPairs::report(const BodyTable& bodies, Frame& frame, StageStats& stats)
{
    if (!stats.skipped) stats.in += frame.swept.size(), stats.out += frame.swept.size();
    std::uint64_t before = 0;
    for (const PairSweep& sweep : frame.sweeps) {
        PairResult& result = frame.results[sweep.pair];
        before += result.verdict != Verdict::separate, stats.out += sweep.verdict != Verdict::separate;
        result.verdict = sweep.verdict, result.kind = sweep.kind;
        if (sweep.verdict != Verdict::undecided) result.stage = StageId::exact;
        if (sweep.verdict == Verdict::separate) result.bound = 0x1p-1000;
        if (sweep.verdict == Verdict::colliding) result.bound = 0;
        if (sweep.verdict == Verdict::within) result.bound = sweep.gap;
        if (sweep.verdict == Verdict::undecided)
            result.bound = farthest_apart(bodies.boxes()[result.a.slot], bodies.boxes()[result.b.slot]);
    }
    stats.out -= std::min(stats.out, before), stats.culled = stats.in - stats.out;
}

void SweepPairs::sweep(const BodyTable& bodies, Frame& frame)
{
    std::vector<SweepTask> tasks;
    for (const Open& open : open_) {
        const std::uint32_t number = frame.sweeps[open.sweep].pair;
        const BodyPair pair = frame.pairs[number];
        Model &a = bodies.model(pair.a), &b = bodies.model(pair.b);
        const bool room = models_.admit_obb_tree(a, frame.number) && models_.admit_obb_tree(b, frame.number);
        tasks.push_back({.a = room ? &a : nullptr,
                         .b = &b,
                         .motion_a = bodies.motion(pair.a),
                         .motion_b = bodies.motion(pair.b),
                         .options = frame.sweep_options,
                         .clearance = frame.settings.clearance,
                         .solid = frame.settings.mode == Mode::solid,
                         .parts_by_poses = frame.parts_by_poses,
                         .begins_apart = !open.met,
                         .memory = frame.settings.coherence ? &frame.cache[number] : nullptr});
    }
    const auto threads = static_cast<std::size_t>(std::max(frame.context.threads, 1));
    if (workers_.size() < threads) workers_ = std::vector<PairWorker>(threads);
    parallel_chunks(tasks.size(), 4, frame.context.threads, [&](std::size_t begin, std::size_t end, int thread) {
        for (std::size_t i = begin; i < end; ++i) {
            PairSweep& sweep = frame.sweeps[open_[i].sweep];
            SweepTask& task = tasks[i];
            const BodyPair pair = frame.pairs[sweep.pair];
            if (!task.a || frame.context.stopped()) continue;
            std::optional<RigidMotion> rest_a, rest_b;
            if (!task.motion_a) task.motion_a = &rest_a.emplace(bodies.pose(pair.a));
            if (!task.motion_b) task.motion_b = &rest_b.emplace(bodies.pose(pair.b));
            static_cast<SweepResult&>(sweep) = sweep_pair(models_, workers_[static_cast<std::size_t>(thread)], task);
        }
    });
}

} // namespace oncollide
