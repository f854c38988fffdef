#include <oncollide/pipeline/refine/fcl_refiner.hpp>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/model.hpp>

namespace oncollide {

void FclRefiner::refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                        std::span<Finding> results)
{
    certain_.assign(results.begin(), results.end());
    exact_.refine(context, tasks, cache, certain_);
    parallel_chunks(tasks.size(), 32, context.threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            if (i % 16 == 0 && context.stopped()) return;
            const PairTask& task = tasks[i];
            const Finding& certain = certain_[i];
            const bool colliding = certain.verdict == Verdict::colliding;
            const bool decided = colliding || certain.verdict == Verdict::separate || certain.kind == ContactKind::near;
            if (decided && fcl_collides(task.a->fcl(), *task.pose_a, task.b->fcl(), *task.pose_b) == colliding)
                results[i] = certain;
        }
    });
}

} // namespace oncollide
