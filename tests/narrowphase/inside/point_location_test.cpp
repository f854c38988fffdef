// The location of points relative to closed meshes, compared with solid angles and exact signs.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/inside/point_location.hpp>
#include <oncollide/samples/generators.hpp>

#include "narrowphase/mesh_parts.hpp"
#include "random_pose.hpp"

namespace oncollide::point_location_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const RelativePose stay(Isometry3d::Identity(), Isometry3d::Identity());

Vector3d random_point(std::uint64_t seed, const Vector3d& from, const Vector3d& to)
{
    Vector3d p;
    for (std::uint64_t k = 0; k < 3; ++k) p[int(k)] = std::lerp(from[int(k)], to[int(k)], u01(seed, 3, k));
    return p;
}

Isometry3d rotated_pose(std::uint64_t seed)
{
    Isometry3d pose = random_pose(seed, 0);
    pose.translation() = random_point(seed, Vector3d(-3, -3, -3), Vector3d(3, 3, 3));
    return pose;
}

/// Located with and without the tree; both results must agree.
PointLocation place_of(const Vector3d& point, const Mesh& mesh, const RelativePose& into = stay)
{
    PointLocator locator;
    ObbTree tree(mesh);
    const PointLocation place = locator.place(point, mesh, &tree, into);
    EXPECT_EQ(locator.place(point, mesh, nullptr, into), place) << point.transpose();
    return place;
}

TEST(PointLocation, EqualsTheWindingNumberBySolidAngles)
{
    const Mesh meshes[] = {make_box_mesh({1, 0.5, 0.25}),
                           make_sphere_mesh(1, 500),
                           make_torus_mesh(1, 0.4, 800),
                           make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 900),
                           make_gear_mesh(9, 0.8, 1, 0.3, 0.3),
                           joined({make_sphere_mesh(1, 300), moved(make_torus_mesh(0.5, 0.2, 300), {0.9, 0, 0})}),
                           joined({make_sphere_mesh(1, 300), flipped(make_sphere_mesh(0.7, 300))})};
    int inside = 0, outside = 0;
    for (const Mesh& mesh : meshes)
        for (std::uint64_t seed = 0; seed < 300; ++seed) {
            const Isometry3d pose = rotated_pose(seed);
            const Vector3d local = random_point(seed, 1.1 * mesh.bounds.min, 1.1 * mesh.bounds.max);
            const double winding = winding_number(mesh, local);
            const double whole = std::round(winding);
            if (std::abs(winding - whole) > 1e-3) continue; // too near the surface for this method
            const PointLocation truth = whole != 0 ? PointLocation::inside : PointLocation::outside;
            ++(whole != 0 ? inside : outside);
            EXPECT_EQ(place_of(local, mesh), truth) << seed;
            const RelativePose into(Isometry3d::Identity(), pose);
            EXPECT_EQ(place_of(into(local), mesh, into), truth) << seed;
        }
    EXPECT_GT(inside, 400);
    EXPECT_GT(outside, 400);
}

/// Points on the faces of tetrahedra, rounded, and moved by a few ulps; the signs of four determinants in integers are
/// the truth.
TEST(PointLocation, IsRightHoweverNearTheSurface)
{
    int count[3] = {};
    for (std::uint64_t seed = 0; seed < 4000; ++seed) {
        std::vector<Vector3d> v;
        for (std::uint64_t i = 0; i < 4; ++i)
            v.push_back(random_point(9 * seed + i, Vector3d(-1, -1, -1), Vector3d(1, 1, 1)));
        const Mesh mesh = make_mesh("tetrahedron", v, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
        const RelativePose into = seed % 2 ? RelativePose(rotated_pose(seed), rotated_pose(seed + 1)) : stay;
        for (Vector3d& corner : v) corner = into(corner);
        Eigen::Vector4d weight;
        for (std::uint64_t k = 0; k < 4; ++k) weight[int(k)] = u01(seed, 5, k) + 0.01;
        weight[int(seed % 4)] = 0;
        weight /= weight.sum();
        Vector3d point = Vector3d::Zero();
        for (int k = 0; k < 4; ++k) point += weight[k] * v[std::size_t(k)];
        for (std::uint64_t k = 0; k < 3; ++k)
            for (int n = int(5 * u01(seed, 6, k)) - 2; n; n -= n > 0 ? 1 : -1)
                point[int(k)] = std::nextafter(point[int(k)], n > 0 ? 2.0 : -2.0);
        const int turn = orient3d_exact(v[0], v[1], v[2], v[3]);
        PointLocation truth = PointLocation::inside;
        for (std::size_t k = 0; k < 4; ++k) { // replaces corner k by the point
            std::vector<Vector3d> w = v;
            w[k] = point;
            const int side = turn * orient3d_exact(w[0], w[1], w[2], w[3]);
            if (side < 0) truth = PointLocation::outside;
            if (side == 0 && truth == PointLocation::inside) truth = PointLocation::surface;
        }
        ++count[int(truth)];
        EXPECT_EQ(place_of(point, mesh, into), truth) << seed;
    }
    EXPECT_GT(count[int(PointLocation::inside)], 500);
    EXPECT_GT(count[int(PointLocation::outside)], 500);
}

/// A box of eight ulps: rays have few directions there, and many meet edges and corners.
TEST(PointLocation, TriesAnotherRayWhereOneTouchesAnEdge)
{
    const double unit = 0x1p-3, far = 0x1p49;
    const Vector3d origin(far, far, far);
    const Mesh box = moved(make_box_mesh(Vector3d(8, 6, 4) * unit), origin);
    int count[3] = {};
    for (std::uint64_t seed = 0; seed < 3000; ++seed) {
        Vector3d step = random_point(seed, Vector3d(-9, -9, -9), Vector3d(9, 9, 9));
        for (int k = 0; k < 3; ++k) step[k] = std::round(step[k]);
        const Vector3d reach = step.cwiseAbs() - Vector3d(8, 6, 4);
        const PointLocation truth = reach.maxCoeff() > 0    ? PointLocation::outside
                                    : reach.maxCoeff() == 0 ? PointLocation::surface
                                                            : PointLocation::inside;
        ++count[int(truth)];
        EXPECT_EQ(place_of(origin + step * unit, box), truth) << step.transpose();
    }
    for (int truth : count) EXPECT_GT(truth, 300);
}

/// Coordinates are rounded to eighths, so that a degenerate triangle gets an area.
TEST(PointLocation, LeavesTrianglesOutThatHadNoArea)
{
    const Mesh ball = make_sphere_mesh(1, 200);
    std::vector<Vector3d> vertices = ball.vertices;
    std::vector<Triangle> triangles = ball.triangles;
    for (std::uint64_t i = 0; i < 100; ++i) {
        Vector3d from = random_point(i, Vector3d(-64, -64, -64), Vector3d(64, 64, 64));
        for (int k = 0; k < 3; ++k) from[k] = std::round(from[k]) / 64;
        const auto n = static_cast<std::uint32_t>(vertices.size());
        for (const double part : {-1.0, 0.25, 1.0}) vertices.push_back(part * from);
        triangles.push_back({n, n + 1, n + 2});
    }
    const Mesh mesh = make_mesh("ball and segments", vertices, triangles);
    ASSERT_EQ(mesh.zero_area, 100u);
    int inside = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        Isometry3d pose = rotated_pose(seed);
        const Vector3d far = Vector3d::Constant(0x1.8p49);
        pose.translation() = far;
        const RelativePose into(Isometry3d::Identity(), pose);
        Mesh rounded = ball;
        for (Vector3d& v : rounded.vertices) v = into(v) - far;
        const Vector3d point = (8 * random_point(seed, Vector3d(-1, -1, -1), Vector3d(1, 1, 1))).array().round() / 8;
        const PointLocation place = place_of(far + point, mesh, into);
        if (place == PointLocation::surface) continue;
        const double winding = winding_number(rounded, point);
        inside += place == PointLocation::inside;
        EXPECT_EQ(place == PointLocation::inside, std::round(winding) != 0) << seed << ": " << winding;
    }
    EXPECT_GT(inside, 30);
}

TEST(PointLocation, KnowsCavitiesByTheirOrientation)
{
    const Mesh ball = make_sphere_mesh(2, 500), core = make_sphere_mesh(1, 300);
    const Vector3d centre(0.1, 0.2, 0.05), wall(1.5, 0.1, 0.2);
    const Mesh hollow = joined({ball, flipped(core)}), filled = joined({ball, core});
    EXPECT_EQ(place_of(centre, hollow), PointLocation::outside);
    EXPECT_EQ(place_of(wall, hollow), PointLocation::inside);
    EXPECT_EQ(place_of(centre, flipped(hollow)), PointLocation::outside);
    EXPECT_EQ(place_of(wall, flipped(hollow)), PointLocation::inside) << "all triangles reversed";
    EXPECT_EQ(place_of(centre, filled), PointLocation::inside) << "one part in another";
    const Mesh overlapping = joined({ball, moved(ball, {2, 0, 0})});
    EXPECT_EQ(place_of({1, 0.1, 0.1}, overlapping), PointLocation::inside) << "in both";
}

TEST(PointLocation, FindsCornersEdgesAndFaces)
{
    const Mesh box = make_box_mesh({1, 2, 3});
    for (const Vector3d& p : {Vector3d(1, 2, 3), Vector3d(1, 2, 0.3), Vector3d(1, 0, 0), Vector3d(-1, 0.7, 2.9)})
        EXPECT_EQ(place_of(p, box), PointLocation::surface) << p.transpose();
    EXPECT_EQ(place_of({0, 0, 0}, box), PointLocation::inside);
    EXPECT_EQ(place_of({1, 2, std::nextafter(3, 4)}, box), PointLocation::outside);
    EXPECT_EQ(place_of({9, 9, 9}, box), PointLocation::outside);
}

TEST(PointLocation, IsTheSameAtEveryScaleAndOffset)
{
    for (const double scale : {1e-150, 1e-9, 1.0, 1e9})
        for (const double offset : {0.0, 1e3, 1e5}) { // in radii
            const Mesh mesh = transformed("ball", make_sphere_mesh(1, 500), scale, Vector3d(offset, 0, -offset));
            const Vector3d centre = mesh.bounds.centre();
            EXPECT_EQ(place_of(centre + scale * Vector3d(0.5, 0.3, -0.2), mesh), PointLocation::inside) << scale;
            EXPECT_EQ(place_of(centre + scale * Vector3d(0.7, 0.7, -0.7), mesh), PointLocation::outside) << scale;
        }
}

} // namespace
} // namespace oncollide::point_location_test
