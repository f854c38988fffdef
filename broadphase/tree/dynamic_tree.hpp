#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <oncollide/broadphase/body_states.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/broadphase/tree/aabb_tree.hpp>
#include <oncollide/broadphase/tree/delimitation.hpp>
#include <oncollide/broadphase/tree/loose_aabbs.hpp>
#include <oncollide/broadphase/tree/pair_filter.hpp>
#include <oncollide/broadphase/tree/pair_lists.hpp>
#include <oncollide/broadphase/tree/tree_search.hpp>

namespace oncollide {

/// A tree that is kept between frames, with the pairs found in it.
///
///     changes -> take_in: update loose AABBs and tree
///             -> few changes:  delimit: find regions near bodies that left their loose AABBs
///                           -> find_near: find pairs of loose AABBs in these regions
///                           -> compare_near: compare the boxes of changed bodies -> pairs
///             -> many changes: find_whole: search the whole tree -> pairs
class DynamicTree final : public TracksBodies {
public:
    DynamicTree(std::string_view name, AabbOrder order, const Options& options)
        : TracksBodies(options), name_(name), tree_(order)
    {
    }
    std::string_view name() const override { return name_; }

    void take_in(const BodyColumns& columns) override;
    std::span<const BodyPair> find_pairs(const BodyColumns& columns, bool whole) override;
    void delimit(const BodyColumns& columns) override;
    std::span<const DelimitationLevel> levels() override;
    std::vector<DelimitedRegion> regions() override;
    std::uint64_t bodies_left() override;
    void survivors(std::vector<std::uint32_t>& bodies) override;
    void query(const BodyColumns& columns, std::span<const Aabb> boxes, std::vector<AabbHit>& hits) const override;
    void query_segments(const BodyColumns& columns, std::span<const Segment> segments,
                        std::vector<AabbHit>& hits) const override;

    std::size_t bytes() const override;
    /// Returns the first fault of the tree, the loose AABBs, the bodies' states or the pairs as text, after
    /// find_pairs(); empty: they have none. Cost: O(n).
    std::string validate(const BodyColumns& columns) const;

private:
    std::string fault_of_bodies() const;
    std::string fault_of_pairs(const BodyColumns& columns) const;
    template <class Search, class Meets>
    void add_hits(std::uint32_t k, Search search, Meets meets, std::vector<AabbHit>& hits) const;
    void rebuild(const BodyColumns& columns);
    void note_places(bool rebuilt);
    void refit(const BodyColumns& columns);
    void loosen(const BodyColumns& columns, std::span<const std::uint32_t> moved);
    void note_escaped(std::span<const std::uint32_t> bodies);
    void collect_queries();
    void find_whole(const BodyColumns& columns, bool changed_only);
    bool many_rest() const;
    void find_near(const BodyColumns& columns);
    void compare_near(const BodyColumns& columns);
    void replace_changed(std::vector<BodyPair>& list, const std::vector<BodyPair>& by);
    bool changed(BodyPair pair) const
    {
        return (bodies_.data()[pair.a] | bodies_.data()[pair.b]) & BodyStates::changed;
    }
    /// For a pair in near_: true if one of its bodies changed, but both stayed within their loose AABBs.
    bool to_compare(BodyPair pair) const
    {
        const std::uint8_t a = bodies_.data()[pair.a], b = bodies_.data()[pair.b];
        return (a | b) & BodyStates::changed && !((a | b) & BodyStates::escaped) && a & b & BodyStates::present &&
               (a | b) & BodyStates::dynamic;
    }
    int threads_for(std::size_t queries) const
    {
        return queries < TreeSearch::worth_threads / 8 ? 1 : options_.threads;
    }
    int threads_for_all() const { return size() < TreeSearch::worth_threads ? 1 : options_.threads; }

    static constexpr std::uint64_t unmarked = ~std::uint64_t{0};

    std::string_view name_;
    AabbTree tree_;
    PairFilter filter_;
    TreeSearch search_;
    Delimitation delimitation_;
    std::vector<std::uint32_t> gone_, come_, moved_, left_, jumped_; ///< scratch: bodies for the tree to change
    LooseAabbs loose_;
    std::vector<std::uint32_t> escaped_; ///< bodies added, or outside their loose AABBs, since pairs were last found
    std::vector<std::uint32_t> queries_; ///< the subset whose pairs are searched for
    std::vector<BodyPair> near_;         ///< superset of pairs_: all pairs that bodies can form within their loose
                                         ///< boxes
    std::vector<BodyPair> pairs_, found_, scratch_, compared_;
    PairLists lists_;
    bool near_are_pairs_ = true;              ///< true if near_ equals pairs_; it is then empty
    bool delimited_ = false;                  ///< true if delimit() has run since the changes were applied
    bool whole_ = true;                       ///< true if the whole tree is searched, not regions of it
    std::uint64_t marked_version_ = unmarked; ///< dynamic_version() of the marks in the tree
    std::uint64_t filters_version_ = 0;       ///< the version at the last take_in()
};

} // namespace oncollide
