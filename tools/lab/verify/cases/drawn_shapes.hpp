#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/geometry.hpp>

#include "verify/oracle/solid_truth.hpp"

// Pairs of shapes, and shapes on ground, at the poses that are hard for contacts.
namespace oncollide::tools {

enum class ShapeKind : std::uint8_t { sphere, capsule, box, hull, cylinder, cone, ellipsoid, half_space };
constexpr std::string_view shape_kinds[] = {"sphere",   "capsule", "box",       "hull",
                                            "cylinder", "cone",    "ellipsoid", "half-space"};

struct ShapePair {
    Shape a, b;
    Eigen::Isometry3d pose_a, pose_b;
    double margin; ///< metres, 0 in half of the cases
    std::string what;
};

/// The pair of a seed, not two half-spaces. At rest with a gap of 0, of a few ulp, in or just beyond the margin, on
/// faces, edges and corners; deep; enclosed; nearly parallel (2^-10 to 2^-40 radians); plates and needles; size ratios
/// to 1e6; far from the origin.
ShapePair draw_shape_pair(ShapeKind a, ShapeKind b, std::uint64_t seed);

enum class GroundKind : std::uint8_t { mesh, terrain, map };
constexpr std::string_view ground_kinds[] = {"mesh", "terrain", "map"};

/// A shape that rests on ground, sinks into it, or is above it.
struct ShapeOnGround {
    GeometryData ground;
    std::vector<oracle::SolidTruth> parts; ///< whose union the ground is; relative to the shape's position
    bool may_be_below;                     ///< the ground is a surface, and all of the shape may be below it
    Shape shape;
    Eigen::Isometry3d pose_ground, pose_shape;
    double margin;
    std::string what;
};
ShapeOnGround draw_shape_on_ground(ShapeKind shape, GroundKind ground, std::uint64_t seed);

} // namespace oncollide::tools
