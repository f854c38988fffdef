#pragma once
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/broadphase/tree/aabb_tree.hpp>
#include <oncollide/broadphase/tree/pair_lists.hpp>

namespace oncollide {

/// Searches a whole tree for overlapping pairs, on several threads.
class TreeSearch {
public:
    static constexpr std::size_t worth_threads = 32768; ///< bodies: fewer take less time than waking threads

    /// Overwrites `pairs` with the pairs whose boxes overlap, with at least one moving body, that `columns` allow;
    /// unsorted.
    /// @param filtered  true if the columns may forbid a pair
    void find_pairs(const AabbTree& tree, const BodyColumns& columns, bool filtered, double margin, int threads,
                    std::vector<BodyPair>& pairs);
    std::size_t bytes() const { return tasks_.bytes() + lists_.bytes(); }

private:
    NodePairs tasks_;
    PairLists lists_;
};

} // namespace oncollide
