#include <oncollide/pipeline/world/sweep_pairs.hpp>

#include <optional>

#include <oncollide/base/threads/parallel.hpp>

namespace oncollide {

namespace {

/// Upper bound on how far any point of the body moves on its way.
double motion_of(const Bodies& bodies, std::uint32_t slot)
{
    const RigidMotion* const motion = bodies.motion(slot);
    if (!motion) return 0;
    if (bodies.model(slot).kind() == Kind::half_space) return std::numeric_limits<double>::infinity();
    const Aabb box = bounds_of(bodies.model(slot).geometry());
    return motion->travel(0, 1, box.centre(), box.half_extent().norm());
}

} // namespace

SweepResult sweep_pair(ModelStore& models, PairWorker& worker, const SweepTask& task)
{
    try {
        return models.with_room([&] { return tests_for(task.a->kind(), task.b->kind()).advance(worker, task); });
    } catch (const ChunkFault& fault) {
        models.note(fault.what());
        return {};
    }
}

bool SweepPairs::apart_on_the_way(const Bodies& bodies, const Frame& frame, std::uint32_t pair)
{
    const PairResult& last = frame.results[pair];
    if (last.verdict != Verdict::separate || last.kind == ContactKind::touching) return false;
    double moved = 0;
    for (const std::uint32_t slot : {last.a.slot, last.b.slot}) {
        if (moved_[slot] < 0) moved_[slot] = motion_of(bodies, slot);
        moved += moved_[slot];
    }
    return last.bound * (1 - 0x1p-18) - moved > frame.settings.clearance * (1 + 0x1p-16);
}

void SweepPairs::run(const Bodies& bodies, Frame& frame)
{
    frame.sweeps.clear(), open_.clear();
    moved_.assign(bodies.slots(), -1);
    for (std::uint32_t i = 0; i < frame.pairs.size(); ++i) {
        if (!bodies.motion(frame.pairs[i].a) && !bodies.motion(frame.pairs[i].b)) continue;
        PairSweep& sweep = frame.sweeps.emplace_back();
        sweep.pair = i;
        if (apart_on_the_way(bodies, frame, i))
            sweep.verdict = Verdict::separate, sweep.clear_until = 1;
        else
            open_.push_back(static_cast<std::uint32_t>(frame.sweeps.size() - 1));
    }
    sweep(bodies, frame);
    for (const PairSweep& sweep : frame.sweeps) {
        PairResult& result = frame.results[sweep.pair];
        result.verdict = sweep.verdict, result.kind = sweep.kind;
        if (sweep.verdict != Verdict::undecided) result.stage = StageId::exact;
        if (sweep.verdict == Verdict::separate) result.bound = 0x1p-1000;
        if (sweep.verdict == Verdict::colliding) result.bound = 0;
        if (sweep.verdict == Verdict::within) result.bound = sweep.gap;
        if (sweep.verdict == Verdict::undecided)
            result.bound = farthest_apart(bodies.boxes()[result.a.slot], bodies.boxes()[result.b.slot]);
    }
}

void SweepPairs::sweep(const Bodies& bodies, Frame& frame)
{
    std::vector<SweepTask> tasks;
    for (const std::uint32_t i : open_) {
        const BodyPair pair = frame.pairs[frame.sweeps[i].pair];
        Model &a = bodies.model(pair.a), &b = bodies.model(pair.b);
        const bool room = models_.admit_obb_tree(a, frame.number) && models_.admit_obb_tree(b, frame.number);
        const std::uint32_t number = frame.sweeps[i].pair;
        tasks.push_back({.a = room ? &a : nullptr,
                         .b = &b,
                         .motion_a = bodies.motion(pair.a),
                         .motion_b = bodies.motion(pair.b),
                         .options = frame.sweep_options,
                         .clearance = frame.settings.clearance,
                         .solid = frame.settings.mode == Mode::solid,
                         .begins_apart = frame.results[number].verdict == Verdict::separate,
                         .memory = frame.settings.coherence ? &frame.cache[number] : nullptr});
    }
    const auto threads = static_cast<std::size_t>(std::max(frame.context.threads, 1));
    if (workers_.size() < threads) workers_ = std::vector<PairWorker>(threads);
    parallel_chunks(tasks.size(), 4, frame.context.threads, [&](std::size_t begin, std::size_t end, int thread) {
        for (std::size_t i = begin; i < end; ++i) {
            PairSweep& sweep = frame.sweeps[open_[i]];
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
