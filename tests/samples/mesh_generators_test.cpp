#include <oncollide/samples/generators.hpp>

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "scenes/test_files.hpp"

namespace oncollide {
namespace {

using Eigen::Vector3d;
using test::expect_error;

double volume(const Mesh& mesh)
{
    double sum = 0;
    for (const Triangle& t : mesh.triangles)
        sum += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]]));
    return sum / 6;
}

void expect_solid(const Mesh& mesh, double expected_volume, double tolerance)
{
    EXPECT_TRUE(is_closed(mesh));
    EXPECT_EQ(mesh.zero_area, 0u);
    EXPECT_NEAR(volume(mesh), expected_volume, tolerance * expected_volume);
}

double longest_over_shortest_edge(const Mesh& mesh)
{
    double least = 1e300, most = 0;
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const double edge = (mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).norm();
            least = std::min(least, edge), most = std::max(most, edge);
        }
    return most / least;
}

TEST(MeshGenerators, ABoxHasTwelveTrianglesAndItsVolume)
{
    const Mesh mesh = make_box_mesh({0.5, 1, 2});
    EXPECT_EQ(mesh.triangles.size(), 12u);
    expect_solid(mesh, 8, 1e-12);
    EXPECT_EQ(mesh.bounds.max, Vector3d(0.5, 1, 2));
}

TEST(MeshGenerators, ASphereMeetsItsCountOnItsSurface)
{
    for (const int count : {8, 12, 14, 20, 32, 100, 128, 777, 1496, 1500, 5110, 5144, 8192, 50000}) {
        SCOPED_TRACE(count);
        const Mesh mesh = make_sphere_mesh(2, count);
        EXPECT_EQ(mesh.triangles.size(), static_cast<std::size_t>(count / 2 * 2));
        // A polytope in a sphere lacks a share of 5 to 20 / triangles of its volume.
        const double full = 32 * std::numbers::pi / 3, least = full * (1 - 20.0 / (count + 16));
        expect_solid(mesh, 0.5 * (least + full), 0.5 * (full - least) / least);
        for (const Vector3d& v : mesh.vertices) EXPECT_NEAR(v.norm(), 2, 1e-14);
    }
    EXPECT_EQ(make_sphere_mesh(1, 9).triangles.size(), 8u) << "8 to 11: an octahedron";
}

TEST(MeshGenerators, ATorusMeetsItsCountOnItsSurface)
{
    for (const int count : {18, 20, 500, 1501, 5144}) {
        SCOPED_TRACE(count);
        const Mesh mesh = make_torus_mesh(3, 1, count);
        EXPECT_EQ(mesh.triangles.size(), static_cast<std::size_t>(count / 2 * 2));
        expect_solid(mesh, 6 * std::numbers::pi * std::numbers::pi, count < 100 ? 0.9 : 0.1);
        for (const Vector3d& v : mesh.vertices) EXPECT_NEAR(std::hypot(std::hypot(v.x(), v.y()) - 3, v.z()), 1, 1e-14);
    }
}

TEST(MeshGenerators, ATorusKnotIsAClosedTube)
{
    const Mesh mesh = make_torus_knot_mesh(2, 3, 2, 0.8, 0.3, 5104);
    EXPECT_EQ(mesh.triangles.size(), 5104u);
    double length = 0; // of the centre line
    const auto centre_line = [](double t) -> Vector3d {
        const double reach = 2 + 0.8 * std::cos(3 * t);
        return {reach * std::cos(2 * t), reach * std::sin(2 * t), 0.8 * std::sin(3 * t)};
    };
    for (int i = 0; i < 1000; ++i)
        length += (centre_line(i * std::numbers::pi / 500) - centre_line((i + 1) * std::numbers::pi / 500)).norm();
    expect_solid(mesh, std::numbers::pi * 0.09 * length, 0.08);
    EXPECT_LT(longest_over_shortest_edge(mesh), 20);
    for (const auto& [p, q] : {std::pair{1, 1}, {1, 4}, {3, 2}, {3, 7}, {5, 1}})
        EXPECT_TRUE(is_closed(make_torus_knot_mesh(p, q, 2, 0.8, 0.1, 2000))) << p << ", " << q;
}

TEST(MeshGenerators, AGearIsClosedAndBetweenItsRadii)
{
    const Mesh mesh = make_gear_mesh(12, 1.0, 1.2, 0.4, 0.3);
    EXPECT_EQ(mesh.triangles.size(), 12u * 32);
    const double disc = std::numbers::pi * 0.4;
    EXPECT_TRUE(is_closed(mesh));
    EXPECT_GT(volume(mesh), disc * (0.95 - 0.09));
    EXPECT_LT(volume(mesh), disc * (1.44 - 0.08));
    for (const Vector3d& v : mesh.vertices) {
        const double radius = std::hypot(v.x(), v.y());
        EXPECT_TRUE(std::abs(radius - 0.3) < 1e-14 || std::abs(radius - 1) < 1e-14 || std::abs(radius - 1.2) < 1e-14);
        EXPECT_EQ(std::abs(v.z()), 0.2);
    }
}

TEST(MeshGenerators, ASheetIsAFlatSquareThatLooksUp)
{
    const Mesh mesh = make_sheet_mesh(3, 5);
    ASSERT_EQ(mesh.triangles.size(), 50u);
    EXPECT_EQ(mesh.bounds.min, Eigen::Vector3d(-1.5, -1.5, 0));
    EXPECT_EQ(mesh.bounds.max, Eigen::Vector3d(1.5, 1.5, 0));
    for (const Triangle& t : mesh.triangles) {
        const Eigen::Vector3d n =
            (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
        EXPECT_NEAR(n.z(), 0.36, 1e-12);
        EXPECT_EQ(n.head<2>(), Eigen::Vector2d::Zero());
    }
}

TEST(MeshGenerators, ASheetMayHaveTwoSidesAndItsOwnCellsAlongEach)
{
    const Mesh mesh = make_sheet_mesh({4, 1}, {8, 3});
    EXPECT_EQ(mesh.vertices.size(), 36u);
    EXPECT_EQ(mesh.triangles.size(), 48u);
    EXPECT_EQ(mesh.bounds.max, Eigen::Vector3d(2, 0.5, 0));
    EXPECT_EQ(mesh.vertices[9], Eigen::Vector3d(-2, 1.0 / 3 - 0.5, 0));
    EXPECT_THROW(make_sheet_mesh({4, 0}, {8, 3}), Error);
    EXPECT_THROW(make_sheet_mesh({4, 1}, {8, 0}), Error);
}

TEST(MeshGenerators, ATerrainIsAHeightFieldThatLooksUp)
{
    const Mesh mesh = make_terrain_mesh(100, 10, 64, 7);
    EXPECT_EQ(mesh.triangles.size(), 2u * 64 * 64);
    EXPECT_FALSE(is_closed(mesh));
    EXPECT_EQ(mesh.bounds.min.head<2>(), Eigen::Vector2d(-50, -50));
    EXPECT_EQ(mesh.bounds.max.head<2>(), Eigen::Vector2d(50, 50));
    EXPECT_GE(mesh.bounds.min.z(), 0);
    EXPECT_LE(mesh.bounds.max.z(), 10);
    EXPECT_GT(mesh.bounds.max.z() - mesh.bounds.min.z(), 3);
    for (const Triangle& t : mesh.triangles) {
        const Vector3d& a = mesh.vertices[t[0]];
        EXPECT_GT((mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).z(), 0);
    }
}

TEST(MeshGenerators, NeedlesHaveTheirLengthAndAspect)
{
    const Mesh mesh = make_needles_mesh(500, 0.5, 1e5, 10, 3);
    ASSERT_EQ(mesh.triangles.size(), 500u);
    EXPECT_EQ(mesh.zero_area, 0u);
    for (const Triangle& t : mesh.triangles) {
        const Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        EXPECT_NEAR((b - a).norm(), 0.5e-5, 1e-12);
        EXPECT_NEAR((c - 0.5 * (a + b)).norm(), 0.5, 1e-12);
        EXPECT_LE(((a + b + c) / 3).cwiseAbs().maxCoeff(), 5.3);
    }
}

TEST(MeshGenerators, SoupHasItsEdges)
{
    const Mesh mesh = make_soup_mesh(500, 0.5, 10, 3);
    ASSERT_EQ(mesh.triangles.size(), 500u);
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const double edge = (mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).norm();
            EXPECT_GT(edge, 0.5 * 0.7);
            EXPECT_LT(edge, 0.5 * 1.3);
        }
}

TEST(MeshGenerators, EqualSeedsGiveEqualMeshesAndOthersDoNot)
{
    EXPECT_EQ(make_soup_mesh(50, 1, 9, 4).vertices, make_soup_mesh(50, 1, 9, 4).vertices);
    EXPECT_NE(make_soup_mesh(50, 1, 9, 4).vertices, make_soup_mesh(50, 1, 9, 5).vertices);
    EXPECT_NE(make_needles_mesh(50, 1, 9, 9, 4).vertices, make_needles_mesh(50, 1, 9, 9, 5).vertices);
    EXPECT_NE(make_terrain_mesh(1, 1, 9, 4).vertices, make_terrain_mesh(1, 1, 9, 5).vertices);
}

TEST(MeshGenerators, ImpossibleArgumentsAreRefused)
{
    const double nan = std::nan("");
    const auto usage = [](auto action, const char* part) { expect_error(ErrorKind::usage, action, part); };
    usage([] { make_box_mesh({1, 0, 1}); }, "half-extent is 0");
    usage([=] { make_box_mesh({1, nan, 1}); }, "half-extent is nan");
    usage([] { make_sphere_mesh(1, 7); }, "from 8 to");
    usage([] { make_sphere_mesh(-1, 100); }, "radius is -1");
    usage([] { make_sphere_mesh(1, 2'000'000'000); }, "from 8 to");
    usage([] { make_torus_mesh(1, 2, 100); }, "tube radius (2) must be below the ring radius (1)");
    usage([] { make_torus_mesh(2, 1, 17); }, "from 18 to");
    usage([] { make_torus_knot_mesh(2, 4, 2, 1, 0.1, 100); }, "no common divisor, not 2 and 4");
    usage([] { make_torus_knot_mesh(0, 1, 2, 1, 0.1, 100); }, "p is 0");
    usage([] { make_gear_mesh(2, 1, 2, 1, 0.5); }, "from 3 to");
    usage([] { make_gear_mesh(12, 1, 1, 1, 0.5); }, "root radius (1) must be below the tip radius (1)");
    usage([] { make_gear_mesh(12, 1, 2, 1, 1); }, "bore radius (1)");
    usage([] { make_terrain_mesh(1, 1, 0, 1); }, "cells is 0");
    usage([] { make_sheet_mesh(0, 4); }, "sheet");
    usage([] { make_needles_mesh(0, 1, 10, 1, 1); }, "count is 0");
    usage([] { make_soup_mesh(-3, 1, 10, 1); }, "count is -3");
}

} // namespace
} // namespace oncollide
