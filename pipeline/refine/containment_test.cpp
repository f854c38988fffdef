#include <oncollide/pipeline/refine/containment_test.hpp>

#include <algorithm>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/pairs/containment.hpp>

namespace oncollide {

void ContainmentTest::find(const RefineContext& context, std::span<const PairTask> tasks,
                           std::span<const std::uint8_t> apart, std::span<Finding> results)
{
    if (context.settings.mode != Mode::solid) return;
    gather(context, tasks, apart);
    if (queries_.empty()) return;
    {
        const auto lock = context.changing();
        for (Query& query : queries_) {
            Model& outer = query.outer_is_a ? *tasks[query.task].a : *tasks[query.task].b;
            query.tree = models_.admit_obb_tree(outer, context.frame) ? outer.obb_tree() : nullptr;
        }
    }
    locators_.resize(static_cast<std::size_t>(std::max(context.threads, 1)));
    parallel_chunks(queries_.size(), 4, context.threads, [&](std::size_t begin, std::size_t end, int thread) {
        for (Query& query : std::span(queries_).subspan(begin, end - begin)) {
            const PairTask& task = tasks[query.task];
            const Model& outer = query.outer_is_a ? *task.a : *task.b;
            query.holds = held_point(task, query.outer_is_a, *outer.surface_mesh(), query.tree,
                                     locators_[static_cast<std::size_t>(thread)])
                              .has_value();
        }
    });
    for (const Query& query : queries_)
        if (query.holds) results[query.task] = {Verdict::colliding, ContactKind::enclosed, 0};
}

void ContainmentTest::gather(const RefineContext& context, std::span<const PairTask> tasks,
                             std::span<const std::uint8_t> apart)
{
    sides_.assign(tasks.size(), 0);
    parallel_chunks(tasks.size(), 256, context.threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!apart[i]) continue;
            const PairTask& t = tasks[i];
            sides_[i] = std::uint8_t((t.a->closed() && may_hold(*t.a, *t.pose_a, *t.b, *t.pose_b)) |
                                     (t.b->closed() && may_hold(*t.b, *t.pose_b, *t.a, *t.pose_a)) << 1);
        }
    });
    queries_.clear();
    for (std::uint32_t i = 0; i < sides_.size(); ++i)
        for (const bool outer_is_a : {true, false})
            if (sides_[i] & (outer_is_a ? 1 : 2)) queries_.push_back({i, outer_is_a, nullptr, false});
}

} // namespace oncollide
