#include <oncollide/pipeline/refine/fcl_refiner.hpp>

#include <oncollide/base/parallel.hpp>

namespace oncollide {

void FclRefiner::refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                        std::span<RefineResult> results)
{
    certain_.assign(results.begin(), results.end());
    exact_.refine(context, tasks, cache, certain_);
    const double clearance = context.settings.clearance;
    parallel_chunks(tasks.size(), 32, context.threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            const PairTask& task = tasks[i];
            const FclResult found = fcl_result(task.a->fcl(clearance > 0), *task.pose_a, task.b->fcl(clearance > 0),
                                               *task.pose_b, clearance);
            if (found.verdict == certain_[i].verdict) results[i] = certain_[i];
        }
    });
}

} // namespace oncollide
