// The kd-tree and the octree as broad phases: all boxes taken in, the whole tree searched.
#include <algorithm>

#include <oncollide/broadphase/box_tree.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/broadphase/pair_sort.hpp>
#include <oncollide/broadphase/tree_search.hpp>

namespace oncollide {

namespace {

class TreeBroadPhase final : public BroadPhase {
public:
    TreeBroadPhase(std::string_view name, BoxOrder order) : name_(name), tree_(order) {}
    std::string_view name() const override { return name_; }

    void find_pairs(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, const BodyFilter& filter,
                    double margin, int threads, std::vector<BodyPair>& pairs) override
    {
        if (bodies.size() < TreeSearch::worth_threads) threads = 1;
        take_in(boxes, bodies, filter, margin, threads);
        search_.find_pairs(tree_, boxes, filter, margin, true, threads, pairs);
        sort_pairs(pairs, scratch_, filter.is_static.size(), threads);
    }

    std::size_t bytes() const override
    {
        return tree_.bytes() + search_.bytes() + bodies_.capacity() * sizeof(bodies_[0]) + is_static_.capacity() +
               scratch_.capacity() * sizeof(BodyPair);
    }

private:
    void take_in(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, const BodyFilter& filter,
                 double margin, int threads)
    {
        const bool same = tree_.view().levels > 0 && std::ranges::equal(bodies, bodies_);
        if (same) tree_.refit(boxes, margin, threads);
        if (!same || tree_.degraded()) {
            tree_.build(boxes, bodies, margin, threads); // first: it may refuse a box, and then nothing has changed
            if (!same) bodies_.assign(bodies.begin(), bodies.end());
            is_static_.clear();
        }
        if (!std::ranges::equal(filter.is_static, is_static_)) {
            is_static_.assign(filter.is_static.begin(), filter.is_static.end());
            tree_.set_moving(is_static_);
        }
    }

    std::string_view name_;
    BoxTree tree_;
    TreeSearch search_;
    std::vector<std::uint32_t> bodies_;   ///< in the tree
    std::vector<std::uint8_t> is_static_; ///< as the tree knows it
    std::vector<BodyPair> scratch_;
};

} // namespace

std::unique_ptr<BroadPhase> make_kd_tree()
{
    return std::make_unique<TreeBroadPhase>("kd", BoxOrder::kd);
}
std::unique_ptr<BroadPhase> make_octree()
{
    return std::make_unique<TreeBroadPhase>("octree", BoxOrder::octree);
}

} // namespace oncollide
