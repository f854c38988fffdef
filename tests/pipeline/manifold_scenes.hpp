// Scenes for tests of manifolds.
#pragma once
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "every_kind.hpp"
#include "random_pose.hpp"

namespace oncollide::manifold_scenes {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double pi = std::numbers::pi;

inline Isometry3d at(double x, double y, double z)
{
    return Isometry3d(Eigen::Translation3d(x, y, z));
}

/// A flat square of `cells` x `cells` cells, seen from above.
inline Mesh flat_ground(double half, int cells)
{
    Mesh mesh;
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (int y = 0; y <= cells; ++y)
        for (int x = 0; x <= cells; ++x)
            vertices.emplace_back(half * (2.0 * x / cells - 1), half * (2.0 * y / cells - 1), 0);
    const auto number = [&](int x, int y) { return static_cast<std::uint32_t>(y * (cells + 1) + x); };
    for (int y = 0; y < cells; ++y)
        for (int x = 0; x < cells; ++x) {
            triangles.push_back({number(x, y), number(x + 1, y), number(x, y + 1)});
            triangles.push_back({number(x + 1, y), number(x + 1, y + 1), number(x, y + 1)});
        }
    return make_mesh("ground", std::move(vertices), std::move(triangles));
}

inline Terrain flat_terrain()
{
    TerrainGrid grid{.columns = 21, .rows = 21};
    grid.spacing = {0.5, 0.5}, grid.origin = {-5, -5, 0};
    return make_terrain("flat", grid, std::vector<double>(441, 0.0));
}

inline OccupancyMap map_ground()
{
    OccupancyMap map = tools::one_cell(0.5);
    std::vector<Vector3d> points;
    for (int x = -10; x < 10; ++x)
        for (int y = -10; y < 10; ++y) points.emplace_back(0.5 * x + 0.25, 0.5 * y + 0.25, -0.25);
    map.set(points, CellState::occupied);
    map.set(std::vector<Vector3d>{{0.25, 0.25, 0.25}}, CellState::free);
    return map;
}

struct Two {
    World world;
    BodyId a, b;
    Two(const GeometryData& of_a, const Isometry3d& pose_a, const GeometryData& of_b, const Isometry3d& pose_b)
        : world({.threads = 1})
    {
        const auto add = [&](const GeometryData& data, const Isometry3d& pose) {
            return world.bodies().add(
                {.model = world.models().add(std::make_shared<const Geometry>(Geometry{"", data, {}})), .pose = pose});
        };
        a = add(of_a, pose_a), b = add(of_b, pose_b);
    }
    Manifold manifold(ManifoldOptions options = {}) const
    {
        options.measures = true;
        return world.pairs().manifold(a, b, options);
    }
};

inline void expect_near(const Vector3d& x, const Vector3d& y, double tolerance, const std::string& what)
{
    EXPECT_NEAR((x - y).norm(), 0, tolerance) << what << ": " << x.transpose() << " and " << y.transpose();
}

/// Checks rules that every manifold keeps.
inline void check(const Manifold& m, const std::string& where)
{
    std::uint32_t points = 0;
    for (const ManifoldRegion& r : m.regions) {
        EXPECT_EQ(r.first, points) << where;
        points += r.count;
        EXPECT_GT(r.count, 0u) << where;
        EXPECT_GE(r.found, r.count) << where;
        EXPECT_NEAR(r.normal.norm(), 1, 1e-12) << where;
        for (const double value : {r.area, r.volume, r.lost, r.normal_error}) EXPECT_GE(value, 0) << where;
        EXPECT_LE(r.normal_error, pi) << where;
        EXPECT_LE(r.depth_lower, r.depth_upper) << where;
        EXPECT_TRUE(r.centre.allFinite() && std::isfinite(r.depth_upper) && std::isfinite(r.lost)) << where;
        for (std::uint32_t k = r.first; k < r.first + r.count; ++k) {
            const ManifoldPoint& p = m.points.at(k);
            EXPECT_TRUE(p.point_a.allFinite() && p.point_b.allFinite()) << where;
            EXPECT_NEAR(r.normal.dot(p.point_a - p.point_b), p.depth, 1e-9 * (1 + p.point_a.norm())) << where;
            EXPECT_NEAR(p.normal.norm(), 1, 1e-12) << where;
            EXPECT_GE(p.normal.dot(r.normal), 0.7071) << where;
            EXPECT_GE(p.depth_error, 0) << where;
            EXPECT_LE(p.depth - p.depth_error, r.depth_upper) << where;
        }
    }
    EXPECT_EQ(points, m.points.size()) << where;
    for (const ManifoldRegion& r : m.regions) // no region repeats a point of an earlier one
        for (std::uint32_t k = r.first; r.count > 1 && k < r.first + r.count; ++k)
            for (std::uint32_t i = 0; i < r.first; ++i) {
                const ManifoldPoint &p = m.points[i], &q = m.points[k];
                EXPECT_FALSE(p.feature_a == q.feature_a && p.feature_b == q.feature_b && p.normal.dot(q.normal) > 0.995)
                    << where;
            }
}

inline const std::pair<const char*, std::function<GeometryData()>> grounds[] = {
    {"mesh",
     [] {
         return GeometryData(make_box_mesh({5, 5, 1}));
     }},
    {"box",
     [] {
         return GeometryData(Shape(Box{{5, 5, 1}}));
     }},
    {"terrain", [] { return GeometryData(flat_terrain()); }},
    {"map", [] { return GeometryData(map_ground()); }},
    {"half-space", [] { return GeometryData(Shape(HalfSpace{})); }},
};
inline double top_of(std::string_view ground)
{
    return ground == "mesh" || ground == "box" ? 1 : 0;
}

} // namespace oncollide::manifold_scenes
