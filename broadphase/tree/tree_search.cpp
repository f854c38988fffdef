#include <oncollide/broadphase/tree/tree_search.hpp>

#include <algorithm>

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/broadphase/aabb_checks.hpp>

namespace oncollide {

void TreeSearch::find_pairs(const AabbTree& tree, const BodyColumns& columns, bool filtered, double margin, int threads,
                            std::vector<BodyPair>& pairs)
{
    ONCOLLIDE_ASSERT(margin >= 0 && threads >= 1);
    const AabbTreeView& view = tree.view();
    const AabbTreeKernel& kernel = aabb_tree_kernel();
    if (tree.size() < worth_threads || view.levels < 3) threads = 1;
    lists_.begin(pairs, threads);
    const auto keep_into = [&](std::vector<BodyPair>& list) {
        return [&](const std::uint32_t* i, const std::uint32_t* j, std::size_t count) {
            append_kept(
                list, count,
                [&](std::size_t k) {
                    const std::uint32_t a = tree.body_at(i[k]), b = tree.body_at(j[k]);
                    return BodyPair{std::min(a, b), std::max(a, b)};
                },
                [&](std::size_t k, BodyPair p) {
                    return (!filtered || columns.allows(p.a, p.b)) &&
                           (tree.surely_overlap(i[k], j[k]) || overlap(columns.boxes[p.a], columns.boxes[p.b], margin));
                });
        };
    };
    if (threads == 1) {
        find_in_chunks(keep_into(lists_.of(0)), [&](PairSink& sink) {
            if (view.levels > 0) kernel.all(view, 0, sink);
        });
    } else {
        // The tasks are the nodes two levels up and the overlapping pairs of these nodes.
        constexpr int level = 2;
        tasks_.clear();
        kernel.all(view, level, tasks_.sink());
        const std::size_t nodes = view.level[level].count, all = nodes + tasks_.size();
        parallel_chunks(all, 16, threads, [&](std::size_t begin, std::size_t end, int thread) {
            find_in_chunks(keep_into(lists_.of(static_cast<std::size_t>(thread))), [&](PairSink& sink) {
                for (std::size_t i = begin; i < end; ++i)
                    if (i < nodes)
                        kernel.within(view, level, static_cast<std::uint32_t>(i), sink);
                    else
                        kernel.between(view, level, tasks_.i()[i - nodes], tasks_.j()[i - nodes], sink);
            });
        });
    }
    lists_.join(pairs);
}

} // namespace oncollide
