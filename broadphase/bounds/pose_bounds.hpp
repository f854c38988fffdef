#pragma once
#include <cstdint>
#include <memory>

#include <oncollide/broadphase/bounds/cooked_support.hpp>
#include <oncollide/scenes/geometry.hpp>
#include <oncollide/scenes/rigid_motion.hpp>

namespace oncollide {

/// Tight world AABBs of one geometry at any pose: boxes of the rotated vertices, not of a sphere.
///
/// Shapes have closed forms. For rotations by quarter turns, a mesh's box comes from its bounds; otherwise from its
/// vertices, through a SupportMap if they are many. Before the first expect() it is the box of the rotated bounds. An
/// occupancy map's box is always the box of its rotated occupied bounds.
class PoseBounds {
public:
    /// Keeps a reference to `geometry`. Cost: O(1).
    explicit PoseBounds(const GeometryData& geometry);

    /// Call it after the bounds of a terrain changed, or vertices of a mesh moved and its bounds were renewed. Not
    /// concurrently with any other call. From now on each expect() after a change of the vertices copies them, instead
    /// of sorting them into a map.
    void deform();

    /// Announces that box() will be called at this pose, and prepares data if this pays off. Not concurrently with any
    /// other call. Affects only the tightness of results. Allocates no memory if no preparation pays off.
    void expect(const Eigen::Isometry3d& pose);
    /// The same for the poses of box() of a motion.
    void expect(const RigidMotion& motion);
    /// True if expect() may still prepare data.
    bool prepares() const { return !final_; }

    /// Encloses the geometry at this pose, rounding included: too large by at most 2^-20 of its size. After expect() at
    /// this pose it depends on geometry and pose only, not on earlier calls, so other processes compute the same box.
    /// Safe from many threads. Cost: 0.1 to 0.2 microseconds for a mesh with its map prepared.
    Aabb box(const Eigen::Isometry3d& pose) const;
    /// The loose AABB: around the bounding sphere of the geometry's own box, at any rotation.
    Aabb sphere_box(const Eigen::Isometry3d& pose) const;

    /// Encloses the geometry at all poses of a motion: the boxes of poses an eighth of a radian apart, and the bulge of
    /// arcs between them. @param tight  of box() at each pose; else of sphere_box()
    Aabb box(const RigidMotion& motion, bool tight = true) const;

    /// Upper bound on the straight-line distance that a point of the geometry moves between two poses, including
    /// deformation by poses that are not exactly rigid. For a rotated half-space, this includes its far end, 2^52 m
    /// away.
    double motion(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) const;
    /// The same for the distance from a pose to any pose of a motion.
    double motion(const Eigen::Isometry3d& from, const RigidMotion& motion) const;
    /// Upper bound on the distance between a point of the geometry and a point that moves at constant speed along the
    /// straight line between its places at two times of a motion, both before the next key of the state.
    /// @param duration  between the two times
    double bulge(const RigidMotion::State& state, double duration) const;

    /// Diagonal of the geometry's own box.
    double diagonal() const { return 2 * half_.norm(); }
    /// Upper bound on the distance of its points from the origin of the body frame.
    double reach() const { return centre_.norm() + radius_; }

    std::size_t bytes() const { return support_.bytes() + points_.bytes() + (cooked_ ? cooked_->bytes() : 0); }

private:
    void set_size();
    void copy_moved_points();
    bool expect(const std::shared_ptr<const CookedMesh>& mesh, const Eigen::Isometry3d& pose);
    bool is_half_space() const;

    const GeometryData& geometry_;
    Eigen::Vector3d centre_, half_; ///< centre and half-extents of the geometry's own box, in the body frame
    double radius_ = 0;             ///< radius of the sphere around that box
    double slack_ = 0;              ///< error bound of double arithmetic, added on every side
    // Either all points relative to the centre, padded to 8 with copies, or a map.
    PointColumns points_;
    SupportMap support_;
    std::unique_ptr<CookedSupport> cooked_; ///< replaces both for a mesh in a file with many chunks
    std::uint64_t requested_ = 0;           ///< number of boxes announced
    bool final_ = false;                    ///< true if there is nothing left to prepare
    enum class Moves : std::uint8_t { none, all_used, some_used };
    Moves moves_ = Moves::none; ///< the vertices of the mesh have moved, and triangles use all or some of them
};

} // namespace oncollide
