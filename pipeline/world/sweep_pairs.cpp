#include <oncollide/pipeline/world/sweep_pairs.hpp>

#include <array>
#include <optional>

#include <oncollide/base/threads/parallel.hpp>

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

void SweepPairs::run(const Bodies& bodies, Frame& frame, StageStats& stats)
{
    if (frame.swept.empty()) return;
    frame.sweeps.assign(frame.swept.size(), {});
    std::vector<SweepTask> tasks;
    const auto task_of = [&](BodyPair pair) {
        return SweepTask{&bodies.model(pair.a),
                         &bodies.model(pair.b),
                         bodies.motion(pair.a),
                         bodies.motion(pair.b),
                         frame.sweep_options,
                         frame.settings.clearance,
                         frame.settings.mode == Mode::solid};
    };
    for (const std::uint32_t i : frame.swept) {
        SweepTask task = task_of(frame.pairs[i]);
        for (Model** const model : {&task.a, &task.b})
            if (!models_.admit_obb_tree(**model, frame.number)) *model = nullptr;
        tasks.push_back(task);
    }
    const auto threads = static_cast<std::size_t>(std::max(frame.context.threads, 1));
    if (workers_.size() < threads) workers_ = std::vector<PairWorker>(threads);
    parallel_chunks(tasks.size(), 4, frame.context.threads, [&](std::size_t begin, std::size_t end, int thread) {
        for (std::size_t i = begin; i < end; ++i) {
            PairSweep& sweep = frame.sweeps[i];
            SweepTask& task = tasks[i];
            const BodyPair pair = frame.pairs[sweep.pair = frame.swept[i]];
            if (!task.a || !task.b || frame.context.stopped()) continue;
            std::array<std::optional<RigidMotion>, 2> rests;
            if (!task.motion_a) task.motion_a = &rests[0].emplace(bodies.pose(pair.a));
            if (!task.motion_b) task.motion_b = &rests[1].emplace(bodies.pose(pair.b));
            static_cast<SweepResult&>(sweep) = sweep_pair(models_, workers_[static_cast<std::size_t>(thread)], task);
        }
    });
    for (const PairSweep& sweep : frame.sweeps) {
        PairResult& result = frame.results[sweep.pair];
        result.verdict = sweep.verdict, result.kind = sweep.kind;
        if (sweep.verdict != Verdict::undecided) result.stage = StageId::exact;
        if (sweep.verdict == Verdict::separate) result.bound = 0x1p-1000;
        if (sweep.verdict == Verdict::colliding) result.bound = 0;
        if (sweep.verdict == Verdict::within) result.bound = sweep.gap;
        ++stats.in, stats.out += sweep.verdict != Verdict::separate;
        stats.undecided += sweep.verdict == Verdict::undecided;
    }
}

} // namespace oncollide
