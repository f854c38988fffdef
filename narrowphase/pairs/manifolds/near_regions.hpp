#pragma once
#include <oncollide/narrowphase/pairs/manifolds/near_pairs.hpp>
#include <oncollide/narrowphase/pairs/manifolds/region_maker.hpp>

namespace oncollide {

/// Regions of surfaces that are at most the margin apart. Keeps its memory.
class NearRegions {
public:
    /// Pairs of triangles that are at most options.margin + near_rounding() apart, and perhaps others.
    std::vector<TrianglePair> triangles;

    /// Appends regions of `triangles`.
    /// @param meets  the surfaces meet; else the nearest triangles have a region, even if no two features have one
    void add(const ManifoldJob& job, bool meets, RegionMaker& maker);

private:
    void add_nearest(const ManifoldJob& job, RegionMaker& maker) const;

    NearSearch search_;
    std::vector<NearPair> near_;
};

} // namespace oncollide
