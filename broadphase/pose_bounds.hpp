#pragma once
#include <cstdint>
#include <memory>

#include <oncollide/broadphase/cooked_support.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// World boxes of one geometry at any pose, tight: the box of the rotated vertices, not of a sphere.
///
/// Shapes have closed forms. A mesh's box comes from its vertices: from the bounds at rotations by quarter turns, else
/// from all, by a SupportMap if they are many; before the first expect() it is the box of the rotated bounds. An
/// occupancy map's box is that of its rotated occupied bounds.
class PoseBounds {
public:
    /// Keeps a reference. Cost: O(1).
    explicit PoseBounds(const GeometryData& geometry);

    /// A box at this pose is about to be requested: prepares what pays. Not beside other calls. Results never depend on
    /// it but for their tightness. Allocates nothing where nothing pays.
    void expect(const Eigen::Isometry3d& pose);
    /// Can there still be anything to prepare?
    bool prepares() const { return !final_; }

    /// Encloses the geometry at this pose, rounding included: at most 2^-20 of its size too large. After expect() of
    /// the pose it depends on geometry and pose alone, whatever else was requested: other processes find the same box.
    /// Safe from many threads at once. Cost: 0.1 to 0.2 microseconds for a mesh, once its map is there.
    Aabb box(const Eigen::Isometry3d& pose) const;
    /// The loose box: of the sphere around the geometry's own box, whatever the rotation.
    Aabb sphere_box(const Eigen::Isometry3d& pose) const;

    /// How far any point of the geometry moves at most from one pose to another, straight; what poses that are not
    /// quite rigid do to it is counted as motion. Of a half-space that turns it is that of its far end, 2^52 m away.
    double motion(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) const;

    /// Of the geometry's own box.
    double diagonal() const { return 2 * half_.norm(); }
    /// How far its points are from the origin of the body's frame, at most.
    double reach() const { return centre_.norm() + radius_; }

    std::size_t bytes() const { return support_.bytes() + points_.bytes() + (cooked_ ? cooked_->bytes() : 0); }

private:
    bool expect(const std::shared_ptr<const CookedMesh>& mesh, const Eigen::Isometry3d& pose);

    const GeometryData& geometry_;
    Eigen::Vector3d centre_, half_; ///< of the geometry's own box, body frame
    double radius_ = 0;             ///< of the sphere around that box
    double slack_ = 0;              ///< added on every side of what is computed in double
    // Points relative to the centre: all, padded to 8 with copies, or, in their place, a map.
    PointColumns points_;
    SupportMap support_;
    std::unique_ptr<CookedSupport> cooked_; ///< of a mesh in a file of many chunks, in place of these
    std::uint64_t requested_ = 0;           ///< boxes
    bool final_ = false;                    ///< is the support what it will be?
};

} // namespace oncollide
