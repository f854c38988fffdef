#pragma once
#include <span>
#include <vector>

#include <oncollide/narrowphase/pairs/manifolds/overlap_patches.hpp>
#include <oncollide/narrowphase/pairs/manifolds/region_maker.hpp>

namespace oncollide {

/// Regions of surfaces that meet without a common volume. Keeps its memory.
class TouchingRegions {
public:
    /// Appends the regions of pairs that meet elsewhere than at lumps that have a volume.
    /// @param meeting  all pairs of triangles that meet, as for `overlap`
    void add(const ManifoldJob& job, std::span<const TrianglePair> meeting, const OverlapPatches& overlap,
             RegionMaker& maker);

private:
    std::vector<TrianglePair> other_pairs(const ManifoldJob& job, std::span<const TrianglePair> meeting,
                                          const OverlapPatches& overlap);

    KeyNumbers vertices_;
    std::vector<std::uint32_t> lump_of_; ///< by number of a vertex
};

} // namespace oncollide
