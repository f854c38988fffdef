#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/verdict.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// Two triangles that meet, of bodies a and b, by number in their meshes.
struct Contact {
    std::uint32_t triangle_a, triangle_b;
    ContactKind kind;                    ///< touching or crossing
    std::array<Eigen::Vector3d, 2> ends; ///< of the segment that both share; world, metres; equal for a point
    Eigen::Vector3d normal_a, normal_b;  ///< unit, world; 0 for a triangle without area
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
    std::uint32_t triangle_a = 0, triangle_b = 0; ///< of two meshes: a pair at most `upper` apart, where that is finite
    /// The two nearest points, in the world, where `upper` is finite: on the bodies, and `upper` apart, but for
    /// rounding and the tolerance; one point of both where they meet.
    Eigen::Vector3d point_a = Eigen::Vector3d::Zero(), point_b = Eigen::Vector3d::Zero();
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
