#pragma once
#include <oncollide/narrowphase/pairs/manifolds/facings.hpp>
#include <oncollide/narrowphase/pairs/manifolds/region_maker.hpp>

namespace oncollide {

/// Regions of bodies that overlap. Keeps its memory between calls.
class CrossingRegions {
public:
    /// Appends the regions of all lumps that have a volume.
    void add(const ManifoldJob& job, const OverlapPatches& overlap, RegionMaker& maker);

private:
    struct Builder;

    LumpParts parts_;
    PatchFacings facings_;
    std::vector<std::array<std::vector<std::uint32_t>, 3>> of_facing_; ///< the numbers of a LumpPart, by direction
    KeyNumbers vertices_;
};

} // namespace oncollide
