#pragma once
#include <string>
#include <vector>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/geometry.hpp>

#include "verify/cases/placed_body.hpp"

namespace oncollide {

constexpr const char* every_kind[] = {"mesh",     "map",         "terrain",   "sphere", "box",       "capsule",
                                      "cylinder", "convex hull", "ellipsoid", "cone",   "half-space"};
constexpr std::size_t kinds = std::size(every_kind);

/// Steep heights, integers times a quarter, with holes and both diagonals.
inline Terrain small_terrain(std::uint64_t seed, int bytes = 0)
{
    TerrainGrid grid{.columns = 7, .rows = 6};
    grid.spacing = {0.375, 0.5}, grid.origin = {-1, -1.25, -0.5}, grid.no_data = -9999, grid.bytes = bytes;
    std::vector<double> heights;
    for (std::uint64_t i = 0; i < 42; ++i)
        heights.push_back(u01(seed, i, 1) < 0.1 ? -9999 : 0.25 * std::floor(5 * u01(seed, i, 0)));
    for (std::uint64_t i = 0; i < 30; ++i) grid.falling.push_back(u01(seed, i, 2) < 0.5);
    return make_terrain("small", grid, heights);
}

/// Cells on all sides of the origin, and some far away: a traversal starts with several of them.
inline OccupancyMap scattered_map(std::uint64_t seed)
{
    OccupancyMap map = tools::one_cell(0.25);
    std::vector<Eigen::Vector3d> points;
    for (std::uint64_t i = 0; i < 40; ++i) {
        const double reach = i < 32 ? 1 : 60;
        points.emplace_back(reach * (2 * u01(seed, i, 7) - 1), reach * (2 * u01(seed, i, 8) - 1),
                            reach * (2 * u01(seed, i, 9) - 1));
    }
    map.set(points, CellState::occupied);
    return map;
}

/// A body of a kind, about 1 m large (except maps with far cells); lengths are multiples of an eighth if possible.
inline GeometryData draw_geometry(std::size_t kind, std::uint64_t seed)
{
    const auto size = [&](std::uint64_t k) { return 0.125 * (1 + std::floor(6 * u01(seed, 50, k))); };
    const Eigen::Vector3d sizes(size(0), size(1), size(2));
    switch (kind) {
    case 0:
        return seed % 2 ? make_torus_knot_mesh(2, 3, 0.4, 0.2, 0.08, 200) : make_box_mesh(sizes);
    case 1:
        return seed % 2 ? scattered_map(seed) : make_building_map(1, 0.5, seed);
    case 2:
        return small_terrain(seed);
    case 3:
        return Shape(Sphere{sizes.x()});
    case 4:
        return Shape(Box{sizes});
    case 5:
        return Shape(Capsule{sizes.x(), seed % 4 ? sizes.y() : 0});
    case 6:
        return Shape(Cylinder{sizes.x(), sizes.y()});
    case 7: {
        ConvexHull hull;
        const auto coordinate = [&](std::uint64_t i, std::uint64_t k) {
            return 0.125 * std::floor(10 * u01(seed, i, k) - 5);
        };
        for (std::uint64_t i = 0; i < 9; ++i)
            hull.points.emplace_back(coordinate(i, 0), coordinate(i, 1), coordinate(i, 2));
        for (int axis = 0; axis < 3; ++axis) hull.points.push_back(0.625 * Eigen::Vector3d::Unit(axis));
        hull.points.emplace_back(-0.625, -0.625, -0.625);
        return Shape(hull);
    }
    case 8:
        return Shape(Ellipsoid{sizes});
    case 9:
        return Shape(Cone{sizes.x(), sizes.y()});
    default:
        return Shape(HalfSpace{});
    }
}

} // namespace oncollide
