#pragma once
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide::test {

/// Equal in every bit, signs of zeros included.
template <class Matrix>
bool same_bits(const Matrix& a, const Matrix& b)
{
    return std::memcmp(a.data(), b.data(), sizeof(double) * std::size_t(a.size())) == 0;
}

inline bool same_points(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b)
{
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (!same_bits(a[i], b[i])) return false;
    return true;
}

inline bool same_box(const Aabb& a, const Aabb& b)
{
    return same_bits(a.min, b.min) && same_bits(a.max, b.max);
}

inline bool same(const Mesh& a, const Mesh& b)
{
    return same_points(a.vertices, b.vertices) && a.triangles == b.triangles && same_box(a.bounds, b.bounds);
}
inline bool same(const OccupancyMap& a, const OccupancyMap& b)
{
    std::vector<std::pair<MapCell, CellState>> of_a, of_b;
    MapAccess::cells(a).each_leaf([&](const MapCell& cell, CellState state) { of_a.push_back({cell, state}); });
    MapAccess::cells(b).each_leaf([&](const MapCell& cell, CellState state) { of_b.push_back({cell, state}); });
    return a.resolution() == b.resolution() && same_box(a.bounds(), b.bounds()) && of_a == of_b;
}
inline bool same(const Terrain& a, const Terrain& b)
{
    if (a.columns() != b.columns() || a.rows() != b.rows() || a.error() != b.error() || a.cells() != b.cells() ||
        !same_bits(a.bounds().min, b.bounds().min) || !same_bits(a.bounds().max, b.bounds().max))
        return false;
    for (std::uint32_t r = 0; r < a.rows(); ++r)
        for (std::uint32_t c = 0; c < a.columns(); ++c)
            if (std::isnan(a.height(c, r)) ? !std::isnan(b.height(c, r)) : a.height(c, r) != b.height(c, r))
                return false;
    for (std::uint32_t y = 0; y < a.cells_y(); ++y)
        for (std::uint32_t x = 0; x < a.cells_x(); ++x)
            if (a.diagonal(x, y) != b.diagonal(x, y)) return false;
    return true;
}
inline bool same(const Sphere& a, const Sphere& b)
{
    return a.radius == b.radius;
}
inline bool same(const Box& a, const Box& b)
{
    return same_bits(a.half, b.half);
}
inline bool same(const Capsule& a, const Capsule& b)
{
    return a.radius == b.radius && a.length == b.length;
}
inline bool same(const Cylinder& a, const Cylinder& b)
{
    return a.radius == b.radius && a.length == b.length;
}
inline bool same(const ConvexHull& a, const ConvexHull& b)
{
    return same_points(a.points, b.points);
}
inline bool same(const Ellipsoid& a, const Ellipsoid& b)
{
    return same_bits(a.semi_axes, b.semi_axes);
}
inline bool same(const Cone& a, const Cone& b)
{
    return a.radius == b.radius && a.length == b.length;
}
inline bool same(const HalfSpace&, const HalfSpace&)
{
    return true;
}
inline bool same(const Shape& a, const Shape& b)
{
    return a.index() == b.index() &&
           std::visit([&](const auto& shape) { return same(shape, std::get<std::decay_t<decltype(shape)>>(b)); }, a);
}

inline bool same(const std::shared_ptr<const CookedMesh>& a, const std::shared_ptr<const CookedMesh>& b)
{
    return a->name() == b->name() && same(a->whole(), b->whole());
}

inline void expect_same_poses(const Scene& a, const Scene& b, const char* when)
{
    for (std::size_t i = 0; i < a.size(); ++i)
        ASSERT_TRUE(same_bits(a.poses[i].matrix(), b.poses[i].matrix()))
            << a.label(SceneBodyId{static_cast<std::uint32_t>(i)}) << " " << when;
}

inline void expect_same_geometries(const Scene& a, const Scene& b, const char* when)
{
    ASSERT_EQ(a.geometries.size(), b.geometries.size());
    for (std::size_t i = 0; i < a.geometries.size(); ++i) {
        const Geometry &g = a.geometries[i], &h = b.geometries[i];
        EXPECT_EQ(g.name, h.name);
        EXPECT_EQ(a.geometries.deforms(i), b.geometries.deforms(i)) << g.name;
        ASSERT_EQ(g.data.index(), h.data.index()) << g.name;
        EXPECT_TRUE(
            std::visit([&](const auto& d) { return same(d, std::get<std::decay_t<decltype(d)>>(h.data)); }, g.data))
            << g.name << " " << when;
    }
}

/// The two scenes are equal in every bit, now and in later frames. Moves both.
inline void expect_same_scene(Scene& a, Scene& b)
{
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.frames, b.frames);
    expect_same_geometries(a, b, "as loaded");
    ASSERT_EQ(a.names, b.names);
    EXPECT_EQ(a.geometry, b.geometry);
    EXPECT_EQ(a.is_static, b.is_static);
    EXPECT_EQ(a.layers, b.layers);
    EXPECT_EQ(a.masks, b.masks);
    EXPECT_EQ(a.groups, b.groups);
    EXPECT_EQ(a.excluded, b.excluded);
    expect_same_poses(a, b, "as loaded");
    Mover move_a, move_b;
    for (const int frame : {0, 1, 7, 59, 1200, 3}) {
        move_a.move(a, frame);
        move_b.move(b, frame);
        expect_same_poses(a, b, ("at frame " + std::to_string(frame)).c_str());
        if (!a.geometries.deforming().empty())
            expect_same_geometries(a, b, ("at frame " + std::to_string(frame)).c_str());
    }
}

} // namespace oncollide::test
