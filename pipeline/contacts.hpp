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

/// Two parts that meet, of bodies a and b. World coordinates, metres.
struct Contact {
    BodyPart a, b;
    /// Of two triangles touching or crossing. Of others unknown where they certainly meet, touching included; near
    /// where rounding hides whether they do (2^-47 of the bodies' sizes and distance; of balls, turned or against round
    /// shapes, and of round shapes).
    ContactKind kind;
    /// Of two triangles the ends of the segment that both share, equal for a point. Of others a point on each, the same
    /// but for rounding.
    std::array<Eigen::Vector3d, 2> ends;
    /// Unit. Of a triangle its own; 0, or opposite to that of a solid, where it has no area. Of a cell and a shape
    /// outward, where its surface is nearest to the point, of an ellipsoid nearly; opposite to the other's where the
    /// point is in the middle of a sphere, a capsule or an ellipsoid.
    Eigen::Vector3d normal_a, normal_b;
};

/// Those of many pairs, one after the other.
struct ContactLists {
    std::vector<Contact> contacts;
    std::vector<std::size_t> ends; ///< by pair: where its contacts end, and the next pair's begin
};

/// How far apart two bodies are.
struct Distance {
    double lower = 0, upper = std::numeric_limits<double>::infinity(); ///< certified bounds, metres; both 0 where they
                                                                       ///< meet; upper infinite if it was not requested
    BodyPart a{},
        b{}; ///< two parts that are at most `upper` apart, where that is finite; the first where solids overlap
    /// The two nearest points, in the world, where `upper` is finite: on the bodies, and `upper` apart, but for
    /// rounding and the tolerance; one point of both where they meet.
    Eigen::Vector3d point_a = Eigen::Vector3d::Zero(), point_b = Eigen::Vector3d::Zero();
};

/// How far two bodies with triangles (meshes, boxes, hulls) reach into each other. World coordinates, metres. The
/// inside of a mesh counts in every mode, if it is closed.
struct Penetration {
    /// Around the points that both surfaces share, the contact curve; empty where they do not meet.
    Aabb contact;
    /// Around these and all vertices of one body inside the other: around all that two closed bodies have in common.
    Aabb overlap;
    /// Certified: a vertex of one body lies inside the other, at least this far from its surface, and none is deeper by
    /// more than 1 %. 0: no vertex does.
    double depth = 0;
    Eigen::Vector3d deepest = Eigen::Vector3d::Zero(); ///< that vertex, if there is one
    bool of_a = true;                                  ///< is it a vertex of body a?
    std::uint32_t vertex = 0;                          ///< its number in the mesh
    /// All that two closed bodies have in common lies between two planes this far apart, but for rounding; infinite
    /// where one of them is not closed. The least of those that were tried: along the axes and some of the normals.
    double thickness = std::numeric_limits<double>::infinity();
    Eigen::Vector3d thin_along = Eigen::Vector3d::Zero(); ///< unit: across these planes
};

// --- Two meshes at two poses, in one line. Poses are rigid: body frame to world, metres.
// Trees are made for each call (5 ns a triangle, and 60 where they are walked); a World keeps them.
// Throw Error{bad_data} for poses that are not rigid, and for a mesh that make_mesh would refuse.

struct CollideResult {
    Verdict verdict; ///< separate or colliding: exact, touching included
    double bound;    ///< separate: certified lower bound on the distance; colliding: 0
};
CollideResult collide(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b, const Eigen::Isometry3d& pose_b);

/// As World::distance().
Distance distance(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b, const Eigen::Isometry3d& pose_b,
                  double tolerance = 0, double farthest = std::numeric_limits<double>::infinity());

/// As World::contacts().
std::vector<Contact> contacts(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b,
                              const Eigen::Isometry3d& pose_b);

} // namespace oncollide
