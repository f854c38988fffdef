#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/body_part.hpp>
#include <oncollide/narrowphase/verdict.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// Two parts that meet, of bodies a and b. World frame, metres.
struct Contact {
    BodyPart a, b;
    /// Two triangles: touching or crossing. Other parts: unknown if they certainly meet (touching included), near if
    /// rounding prevents a decision. The rounding is 2^-47 of the bodies' sizes and distance; it matters only for
    /// rotated spheres, for spheres against round shapes, and for round shapes.
    ContactKind kind;
    /// Two triangles: the ends of the segment that both share, equal for a point. Other parts: a point on each; the two
    /// points differ only by rounding.
    std::array<Eigen::Vector3d, 2> ends;
    /// Unit normals. A triangle has its own normal; without an area, 0 or the opposite of a solid's normal. A cell or a
    /// shape has the outward normal of its surface at the point nearest to `ends` (an ellipsoid nearly), or the
    /// opposite of the other part's normal if the point is the centre of a sphere, a capsule or an ellipsoid.
    Eigen::Vector3d normal_a, normal_b;
};

/// The contacts of many pairs: contacts[offsets[i]] up to contacts[offsets[i + 1]] belong to pair i.
struct ContactLists {
    std::vector<Contact> contacts;
    std::vector<std::size_t> offsets; ///< one more than there are pairs; the first is 0
};

/// How far apart two bodies are.
struct Distance {
    double lower = 0, upper = std::numeric_limits<double>::infinity(); ///< certified bounds, metres; both 0 where they
                                                                       ///< meet; upper infinite if it was not requested
    BodyPart a{},
        b{}; ///< two parts that are at most `upper` apart, where that is finite; the first where solids overlap
    /// The two nearest points in the world frame, if `upper` is finite. They lie on the bodies and are `upper` apart,
    /// to rounding and the tolerance. If the bodies meet, both are one common point.
    Eigen::Vector3d point_a = Eigen::Vector3d::Zero(), point_b = Eigen::Vector3d::Zero();
};

/// How deep two bodies with triangles (meshes, boxes, hulls) penetrate each other. World frame, metres. A closed mesh
/// has an inside in every mode.
struct Penetration {
    /// Around the points that both surfaces share, the contact curve; empty where they do not meet.
    Aabb contact;
    /// Around these points and all vertices of one body inside the other: around the overlap of two closed bodies.
    Aabb overlap;
    /// Certified: a vertex of one body lies inside the other, at least this far from its surface, and none is deeper by
    /// more than 1 %. 0: no vertex does.
    double depth = 0;
    Eigen::Vector3d deepest = Eigen::Vector3d::Zero(); ///< that vertex, if there is one
    bool of_a = true;                                  ///< is it a vertex of body a?
    std::uint32_t vertex = 0;                          ///< its number in the mesh
    /// The overlap of two closed bodies lies between two planes this far apart, to rounding; infinite if a body is not
    /// closed. It is the smallest of the tested distances: along the axes and some of the normals.
    double thickness = std::numeric_limits<double>::infinity();
    Eigen::Vector3d thin_along = Eigen::Vector3d::Zero(); ///< unit: across these planes
};

// --- Two meshes at two poses, in one line. Poses are rigid: body frame to world, metres.
// Each call builds its trees (5 ns per triangle, 60 ns per traversed triangle); a World keeps them.
// Throw Error{bad_data} for poses that are not rigid, and for a mesh that make_mesh would refuse.

/// Exact: the verdict is separate or colliding; touching counts as colliding.
Finding collide(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b, const Eigen::Isometry3d& pose_b);

/// As World::distance().
Distance distance(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b, const Eigen::Isometry3d& pose_b,
                  double tolerance = 0, double cutoff = std::numeric_limits<double>::infinity());

/// As World::contacts().
std::vector<Contact> contacts(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b,
                              const Eigen::Isometry3d& pose_b);

} // namespace oncollide
