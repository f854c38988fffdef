#pragma once
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/geometry.hpp>

#include "truth/boxed_triangles.hpp"

// The truth about two bodies, without the library's trees, traversals and predicates.
namespace oncollide::tools {

/// Bounds on the distance of two bodies at their stored poses.
struct DistanceTruth {
    double low = 0, high = 0;
    double size = 0; ///< of surfaces: largest coordinate relative to a's position; of others: the larger diagonal
};

/// The truth about two bodies. Its contacts are exact for b's vertices rounded in a's frame, as in exact results.
struct PairTruth {
    /// Surfaces: two triangles meet, exactly. Others: they overlap, by more than rounding where one of them is round.
    bool collide = false;
    bool open = false; ///< rounding decides whether they collide: both results are right
    /// They cross deeply enough that rounding of a motion cannot separate them. Surfaces: an edge of one pierces a
    /// triangle of the other with 2^-30 of the bodies' size to spare on all sides.
    bool deep = false;
    /// The strongest contact of two triangles. Meshes with an inside that only touch: crossing if one of 500 points in
    /// the intersection of their AABBs is inside both.
    TriangleContact contact = TriangleContact::separate;
    bool vague = false; ///< that intersection is so thin that the library may overlook it, docs/results.md
    /// The surfaces are apart, and one of them, being closed, winds around a part of the other body. Either orientation
    /// counts, so a part inside out is a cavity, and a mesh that is inside out as a whole is like any other.
    bool enclosed = false;
    bool kinds = true;      ///< `contact` is the strongest one; false: some contact
    bool surfaces = true;   ///< both are meshes or terrains; spheres around them cannot prove a collision
    bool uncertain = false; ///< a terrain's heights have an error, so exact levels may leave the pair undecided
    /// low is 0 if they collide. Unknown: from 0 to infinity.
    DistanceTruth distance{.high = std::numeric_limits<double>::infinity()};
    double slack = 0;                  ///< error of this distance and of certified bounds, metres
    std::optional<bool> fcl_collide{}; ///< FCL's result, if it was computed
};

/// A geometry, prepared. A terrain is the mesh of its heights. The geometry must outlive it.
class TruthModel {
public:
    /// @param solid  a closed mesh has an inside
    TruthModel(const GeometryData& geometry, bool solid = true);
    TruthModel(const Mesh& mesh, bool solid = true); ///< only against other surfaces
    TruthModel(const TruthModel&) = delete;

    /// True of meshes and terrains.
    bool is_surface() const { return halved_.has_value(); }
    const HalvedMesh& halved() const { return *halved_; }
    const BoxedTriangles& at_home() const { return *at_home_; }
    const GeometryData& geometry() const { return *geometry_; }
    /// True if this mesh, transformed to `here`, has the point inside. False if it is no closed mesh.
    bool winds_around(const BoxedTriangles& here, const Eigen::Vector3d& point) const;
    bool has_inside() const { return closed_; }
    /// A vertex of each part. A part that does not meet a surface lies on one side of it with this vertex.
    const std::vector<std::uint32_t>& part_vertices() const { return part_vertices_; }
    bool is_uncertain() const; ///< a terrain whose heights have an error

private:
    void prepare(const Mesh& mesh, bool solid);

    const GeometryData* geometry_ = nullptr; ///< null: given as a mesh
    std::shared_ptr<const Mesh> made_;       ///< of a terrain
    std::optional<HalvedMesh> halved_;
    std::optional<BoxedTriangles> at_home_;
    bool closed_ = false;
    std::vector<std::uint32_t> part_vertices_;
};

/// truth_of() computes these parts of surfaces, besides `collide`.
struct TruthParts {
    bool kinds = true, deep = true, distance = true;
    double within = 0; ///< of others, distances up to this are searched first
};

/// Surfaces: linear programming and winding numbers, both in integers; distances in long double. Others: convex sets in
/// extended precision.
PairTruth truth_of(const TruthModel& a, const Eigen::Isometry3d& pose_a, const TruthModel& b,
                   const Eigen::Isometry3d& pose_b, const TruthParts& parts = {});

/// Computes the distance of a truth without it, for the same bodies.
void measure(PairTruth& truth, const TruthModel& a, const Eigen::Isometry3d& pose_a, const TruthModel& b,
             const Eigen::Isometry3d& pose_b);

/// The strongest contact of two triangles of the surfaces, exactly: linear programming in integers (exact_oracle.hpp)
/// for every pair that no plane certainly separates. Stops once the contact is `enough`. Cost: 0.1 microseconds per
/// pair of triangles whose AABBs overlap, 10 to 100 if no gap is wider than rounding.
TriangleContact contact_of(const BoxedTriangles& a, const BoxedTriangles& b, TriangleContact enough);

/// Calls look(i, j) for all pairs of triangles that meet.
void for_meeting_triangles(const BoxedTriangles& a, const BoxedTriangles& b,
                           FunctionRef<void(std::uint32_t i, std::uint32_t j)> look);

/// True if an edge of one surface pierces a triangle of the other, as PairTruth::deep says.
bool cross_deeply(const BoxedTriangles& a, const BoxedTriangles& b);

/// Bounds on the distance of two surfaces: nearest points give the upper bound, separating planes the lower; both have
/// an error of 2^-56 of the size.
DistanceTruth surface_distance(const HalvedMesh& a, const Eigen::Isometry3d& pose_a, const HalvedMesh& b,
                               const Eigen::Isometry3d& pose_b);

/// True if some triangle has an area, and as many such triangles traverse each edge in one direction as in the other.
bool has_inside(const Mesh& mesh);

} // namespace oncollide::tools
