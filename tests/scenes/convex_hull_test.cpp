#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/model/convex_hull.hpp>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "test_files.hpp"
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

Vector3d random_vector(std::uint64_t index)
{
    return {2 * u01(1, index, 0) - 1, 2 * u01(1, index, 1) - 1, 2 * u01(1, index, 2) - 1};
}

Points random_cube(std::size_t count)
{
    Points points;
    for (std::size_t i = 0; i < count; ++i) points.push_back(random_vector(i));
    return points;
}

Points random_ball_surface(std::size_t count)
{
    Points points = random_cube(count);
    for (Vector3d& p : points) p.normalize();
    return points;
}

double diagonal(const Points& points)
{
    Aabb bounds;
    for (const Vector3d& p : points) bounds.add(p);
    return bounds.diagonal();
}

/// The contract, checked by brute force: in any of many directions, no point extends farther than the vertices, up to
/// the slack and the rounding of this check.
void expect_hull(const Points& points, const Hull& hull, double most_slack)
{
    ASSERT_FALSE(hull.vertices.empty());
    EXPECT_TRUE(std::is_sorted(hull.vertices.begin(), hull.vertices.end()));
    EXPECT_EQ(std::adjacent_find(hull.vertices.begin(), hull.vertices.end()), hull.vertices.end());
    EXPECT_LT(hull.vertices.back(), points.size());
    EXPECT_GE(hull.slack, 0);
    EXPECT_LE(hull.slack, most_slack);
    const Vector3d origin = points[0];
    const double rounding = 1e-15 * diagonal(points);
    Points directions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    for (std::size_t i = 0; i < 300; ++i) directions.push_back(random_vector(i + 1000000).normalized());
    for (const Triangle& t : hull.triangles) {
        const Vector3d n = (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
        if (directions.size() < 1000 && n.norm() > 0) directions.push_back(n.normalized());
    }
    for (const Vector3d& d : directions) {
        double all = -1e300, kept = -1e300;
        for (const Vector3d& p : points) all = std::max(all, d.dot(p - origin));
        for (const std::uint32_t v : hull.vertices) kept = std::max(kept, d.dot(points[v] - origin));
        ASSERT_LE(all, kept + hull.slack + rounding);
    }
}

void expect_outward_and_closed(const Points& points, const Hull& hull)
{
    ASSERT_FALSE(hull.triangles.empty());
    const Mesh mesh = make_mesh("hull", points, hull.triangles);
    EXPECT_TRUE(is_closed(mesh));
    double volume = 0;
    for (const Triangle& t : hull.triangles)
        volume += (points[t[0]] - points[0]).dot((points[t[1]] - points[0]).cross(points[t[2]] - points[0]));
    EXPECT_GT(volume, 0);
    for (const Triangle& t : hull.triangles)
        for (const std::uint32_t v : t) EXPECT_TRUE(std::binary_search(hull.vertices.begin(), hull.vertices.end(), v));
}

void expect_all_points(const Points& points)
{
    const Hull hull = convex_hull(points);
    EXPECT_EQ(hull.vertices.size(), points.size());
    EXPECT_TRUE(hull.triangles.empty());
    EXPECT_EQ(hull.slack, 0);
}

TEST(ConvexHull, AllPointsAreInTheHullAsFarAsTheSlack)
{
    for (const std::size_t count : {4u, 5u, 10u, 100u, 3000u}) {
        SCOPED_TRACE(count);
        const Points points = random_cube(count);
        const Hull hull = convex_hull(points);
        expect_hull(points, hull, 1e-13);
        expect_outward_and_closed(points, hull);
    }
}

TEST(ConvexHull, EveryPointOfASphereIsAVertex)
{
    const Points points = random_ball_surface(2000);
    const Hull hull = convex_hull(points);
    EXPECT_EQ(hull.vertices.size(), 2000u);
    EXPECT_EQ(hull.slack, 0);
    expect_outward_and_closed(points, hull);
}

TEST(ConvexHull, ABoxOfManyPointsKeepsItsCorners)
{
    Points points; // a grid: many points in each face's plane and on each edge
    for (int x = 0; x < 12; ++x)
        for (int y = 0; y < 12; ++y)
            for (int z = 0; z < 12; ++z) points.push_back(0.1 * Vector3d(x, y, z));
    const Hull hull = convex_hull(points);
    expect_hull(points, hull, 1e-13);
    expect_outward_and_closed(points, hull);
    EXPECT_LT(hull.vertices.size(), 100u);
}

TEST(ConvexHull, HoldsFarFromTheOriginAndAtAnyScale)
{
    for (const double scale : {1e-6, 1.0, 1e6})
        for (const double offset : {0.0, 1e6, -1e8}) {
            SCOPED_TRACE(testing::Message() << scale << " at " << offset);
            Points points = random_cube(500);
            for (Vector3d& p : points) p = scale * p + Vector3d::Constant(offset * scale);
            const Hull hull = convex_hull(points);
            expect_hull(points, hull, 1e-13 * scale + 1e-14 * std::abs(offset * scale));
            expect_outward_and_closed(points, hull);
        }
    Points points = random_cube(500); // the size is near the rounding of the coordinates
    for (Vector3d& p : points) p = 1e-8 * p + Vector3d::Constant(1e6);
    expect_hull(points, convex_hull(points), 1e-8);
}

TEST(ConvexHull, FewFlatStraightOrEqualPointsAreAllKept)
{
    expect_all_points({{1, 2, 3}});
    expect_all_points({{1, 2, 3}, {4, 5, 6}});
    expect_all_points({{1, 2, 3}, {4, 5, 6}, {7, 8, 10}});
    expect_all_points(Points(100, Vector3d(0.1, 0.2, 0.3)));
    Points line, plane, tilted;
    for (int i = 0; i < 50; ++i) line.push_back(Vector3d(0.1, 0.2, 0.3) * i);
    for (const Vector3d& p : random_cube(200)) {
        plane.push_back({p.x(), p.y(), 5});
        tilted.push_back(p.x() * Vector3d(1, 2, 3) + p.y() * Vector3d(-2, 1, 5));
    }
    expect_all_points(line);
    expect_all_points(plane);
    const Hull hull = convex_hull(tilted); // rounded: a slab of about 1e-16, which may or may not count as flat
    expect_hull(tilted, hull, 1e-14);
}

TEST(ConvexHull, ThinSlabsAreCoveredHoweverThin)
{
    for (const double thickness : {1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 1e-15, 1e-17}) {
        SCOPED_TRACE(thickness);
        Points points = random_cube(1000);
        for (Vector3d& p : points) p.z() *= thickness;
        expect_hull(points, convex_hull(points), 1e-10 * diagonal(points));
    }
}

TEST(ConvexHull, DuplicatesDoNotHarm)
{
    Points points = random_cube(50);
    for (int i = 0; i < 3; ++i) points.insert(points.end(), points.begin(), points.begin() + 50);
    const Hull hull = convex_hull(points);
    expect_hull(points, hull, 1e-13);
    expect_outward_and_closed(points, hull);
}

TEST(ConvexHull, SaysNothingOnTheTerminal)
{
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    Points points = random_cube(100);
    convex_hull(points);
    for (Vector3d& p : points) p.z() = 0;
    convex_hull(points);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

TEST(ConvexHull, CoversGeneratedAndRealMeshes)
{
    for (const Mesh& mesh : {make_torus_mesh(2, 0.5, 2000), make_gear_mesh(20, 1, 1.2, 0.5, 0.2),
                             make_torus_knot_mesh(2, 3, 1, 0.4, 0.1, 4000), make_terrain_mesh(10, 1, 30, 1)}) {
        const Hull hull = convex_hull(mesh.vertices);
        expect_hull(mesh.vertices, hull, 1e-13 * mesh.bounds.diagonal());
        expect_outward_and_closed(mesh.vertices, hull);
    }
}

TEST(ConvexHull, HoldsScannedMeshesOfTheDataFolder)
{
    if (test::data_folder().empty()) GTEST_SKIP() << "skipped: no data";
    for (const char* name :
         {"poses/bunny_5110.obj", "meshes/bunny_69k.obj", "meshes/teapot.obj", "meshes/beetle.obj"}) {
        SCOPED_TRACE(name);
        const Mesh mesh = load_mesh(test::data_folder() / name);
        const Hull hull = convex_hull(mesh.vertices);
        expect_hull(mesh.vertices, hull, 1e-11 * mesh.bounds.diagonal());
        expect_outward_and_closed(mesh.vertices, hull);
        EXPECT_LT(hull.vertices.size(), mesh.vertices.size() / 2);
    }
}

} // namespace
} // namespace oncollide
