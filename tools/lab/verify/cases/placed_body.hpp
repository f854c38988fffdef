#pragma once
#include <array>
#include <cstdint>
#include <memory>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/scenes/geometry.hpp>

// Bodies at poses, and bodies whose coordinates are integers.
namespace oncollide::tools {

struct PlacedBody {
    GeometryData geometry;
    Eigen::Isometry3d pose;
};

inline ModelId add_model(World& world, const GeometryData& geometry)
{
    return world.models().add(std::make_shared<const Geometry>(Geometry{{}, geometry, {}}));
}

inline Eigen::Isometry3d moved_to(const Eigen::Vector3d& at)
{
    return Eigen::Isometry3d(Eigen::Translation3d(at));
}

/// A map of one cell, whose lowest corner is the origin.
OccupancyMap one_cell(double side);

/// A point in units of a grid.
using Place = std::array<std::int64_t, 3>;
using PlaceTriangle = std::array<Place, 3>;

inline Eigen::Vector3d vector_of(const Place& p)
{
    return {double(p[0]), double(p[1]), double(p[2])};
}
inline TrianglePoints points_of(const PlaceTriangle& t)
{
    return {vector_of(t[0]), vector_of(t[1]), vector_of(t[2])};
}

/// A grid in the world.
struct GridFrame {
    double unit; ///< metres, a power of two
    Eigen::Vector3d offset;

    Eigen::Vector3d point(const Place& p) const { return unit * vector_of(p); }
    Eigen::Isometry3d at(const Place& p) const { return moved_to(offset + point(p)); }
};

/// A box in each of the forms that a body can have.
enum class BoxForm { cell, shape, hull, mesh };
/// @param low, high  its corners; a cell is a cube
PlacedBody make_box(BoxForm form, const GridFrame& frame, const Place& low, const Place& high);
PlacedBody make_triangle(const GridFrame& frame, const PlaceTriangle& triangle);

} // namespace oncollide::tools
