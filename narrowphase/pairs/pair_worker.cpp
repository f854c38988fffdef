#include <oncollide/narrowphase/pairs/pair_worker.hpp>

namespace oncollide {

Traversal::Counts PairWorker::counts() const
{
    Traversal::Counts sum;
    each_traversal(*this, [&](const auto& traversal) {
        const auto counts = traversal.counts();
        sum.box_rows += counts.box_rows, sum.triangles += counts.triangles, sum.unsure += counts.unsure;
        sum.hints_held += counts.hints_held;
    });
    each_walk(*this, [&](const auto& walk) {
        sum.box_rows += walk.box_rows, sum.triangles += walk.leaves().tested, sum.hints_held += walk.hints_held;
    });
    return sum;
}

void PairWorker::reset_counts()
{
    each_traversal(*this, [](auto& traversal) { traversal.reset_counts(); });
    each_walk(*this, [](auto& walk) { walk.box_rows = walk.hints_held = 0, walk.leaves().tested = 0; });
}

} // namespace oncollide
