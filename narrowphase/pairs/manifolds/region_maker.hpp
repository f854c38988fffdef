#pragma once
#include <span>

#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/narrowphase/obb/terrain_tree.hpp>
#include <oncollide/narrowphase/pairs/manifolds/manifold_job.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/point_choice.hpp>
#include <oncollide/narrowphase/pairs/manifolds/region_draft.hpp>
#include <oncollide/narrowphase/rays/segment_walk.hpp>
#include <oncollide/narrowphase/rays/terrain_walk.hpp>

namespace oncollide {

/// Makes a region of its draft. Keeps its memory.
class RegionMaker {
public:
    RegionDraft draft; ///< for the caller to fill, between begin() and finish()

    /// Chooses the points of the draft, which has at least one candidate, completes the region, and appends both.
    void finish(const ManifoldJob& job);

private:
    void drop_idle(bool resolved);
    void resolve(const ManifoldJob& job, bool all_angles, ManifoldCandidate& c);
    std::span<const std::uint32_t> choose_resolved(const ManifoldJob& job);
    double way_out(const PlacedSurface& surface, const Eigen::Vector3d& from, const Eigen::Vector3d& along,
                   double most);
    ManifoldPoint point_of(const ManifoldJob& job, const ManifoldCandidate& c);

    std::array<FacesAhead, 2> ahead_; ///< the draft's faces
    bool curved_ = false;             ///< the faces are curved, as on a screw thread: no point has the normal of the
                                      ///< region
    PointChoice choice_;
    SegmentWalk<ObbTree> ways_out_;
    SegmentWalk<TerrainTree> ways_out_of_terrain_;
};

} // namespace oncollide
