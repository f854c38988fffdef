#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/broadphase/tree/aabb_tree.hpp>
#include <oncollide/broadphase/tree/pair_lists.hpp>

namespace oncollide {

/// Progressive delimitation: descends a hierarchy of regions from the whole scene and examines only the regions that
/// overlap one of a set of boxes (the queries). A region that no query overlaps, or in which layers or groups forbid
/// every pair, is rejected whole, at the highest possible level. The regions are the upper levels of the tree that the
/// broad phase searches next; the survivors are stored as pairs (query, leaf region).
///
/// If boxes lie in one heap, most queries overlap most regions. Then no pairs are stored, no region counts as
/// rejected, and the broad phase descends the tree once per query: memory stays O(n + queries).
///
/// Cost: O(queries * levels), independent of the number of bodies, except in a heap.
/// Source: Franquesa-Niubó and Brunet, "Collision prediction using MKtrees", CEIG 2004, for the idea.
class Delimitation {
public:
    /// The filters that forbid pairs of a query.
    struct Filter {
        std::uint32_t layers = ~0u, mask = ~0u, group = mixed_groups; ///< group: a forbidding_group()
    };
    void clear();
    /// Adds a query box: lo x y z, hi x y z, as from AabbTree::box_at().
    void add(const float box[6], const Filter& filter);
    /// Runs the delimitation.
    /// @param filters  also reject regions in which layers or groups forbid every pair; the tree must have filters
    void run(const AabbTree& tree, bool filters, int threads);
    /// True if run() gave up because too little was rejected, so there is no data on regions.
    bool in_a_heap() const { return in_a_heap_; }

    /// The number of workers that compare() uses, at most run()'s `threads`.
    std::size_t workers() const { return workers_; }
    /// The broad phase after run(): passes the slots whose boxes overlap queries' boxes in chunks to found(worker,
    /// queries, places, count), worker < workers().
    using Found = FunctionRef<void(std::size_t worker, const std::uint32_t* queries, const std::uint32_t* places,
                                   std::size_t count)>;
    void compare(const AabbTree& tree, int threads, Found found) const;

    const float* box(std::size_t k) const { return &boxes_[6 * k]; }
    // Statistics, counted on request after run(), on the same tree.
    std::span<const DelimitationLevel> levels(const AabbTree& tree);
    std::vector<DelimitedRegion> regions(const AabbTree& tree);
    /// The number of bodies in the leaf regions that are left.
    std::uint64_t bodies_left(const AabbTree& tree);
    /// Overwrites `bodies` with these bodies, ascending.
    void survivors(const AabbTree& tree, std::vector<std::uint32_t>& bodies);
    std::size_t bytes() const;

private:
    template <class Work>
    void each_worker(int threads, Work work) const;
    void descend(const AabbLevelView& level, bool filters, const NodePairs& from, NodePairs& to,
                 std::atomic<std::int64_t>& room) const;
    void drop_forbidden(const AabbLevelView& level, PairSink& found, std::uint64_t first) const;
    void count(const AabbTree& tree);
    void mark(const AabbTree& tree);
    void count_rejected(const AabbTree& tree);

    std::size_t queries() const { return filters_.size(); }
    std::size_t first_query(std::size_t worker) const { return queries() * worker / workers_; }

    std::vector<float> boxes_;    ///< 6 floats per query
    std::vector<Filter> filters_; ///< by query
    std::size_t workers_ = 1;
    bool in_a_heap_ = false;
    std::vector<std::unique_ptr<NodePairs>> reached_, next_; ///< by worker: (query, node)
    std::vector<std::vector<std::uint32_t>> left_;           ///< by level: nodes that survive, each once
    std::vector<std::vector<std::uint8_t>> is_left_;         ///< by level and node
    std::vector<DelimitationLevel> levels_;
    std::uint64_t bodies_left_ = 0;
    bool counted_ = true;
};

} // namespace oncollide
