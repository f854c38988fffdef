// Manifolds of scenes with known areas, volumes and depths.
#include <algorithm>

#include "pipeline/manifold_scenes.hpp"

namespace oncollide::manifold_scenes {
namespace {

TEST(Manifolds, ABoxSunkIntoEveryGround)
{
    for (const auto& [name, make] : grounds)
        for (const bool mesh : {true, false})
            for (const double aside : {0.0, 0.123}) {
                const std::string where = std::string(name) + (mesh ? " mesh " : " box ") + std::to_string(aside);
                const Vector3d half(0.6, 0.4, 0.5);
                const double depth = 1.0 / 1024;
                const GeometryData body = mesh ? GeometryData(make_box_mesh(half)) : GeometryData(Shape(Box{half}));
                const Two two(body, at(aside, -aside, 0.5 - depth), make(), at(0, 0, -top_of(name)));
                const Manifold m = two.manifold();
                check(m, where);
                ASSERT_EQ(m.regions.size(), 1u) << where;
                const ManifoldRegion& r = m.regions[0];
                EXPECT_EQ(r.kind, RegionKind::crossing) << where;
                EXPECT_FALSE(r.open) << where;
                expect_near(r.normal, {0, 0, -1}, 1e-9, where);
                EXPECT_LT(r.normal_error, 1e-6) << where;
                EXPECT_NEAR(r.area, 4 * half.x() * half.y(), 1e-9) << where;
                EXPECT_NEAR(r.volume, 4 * half.x() * half.y() * depth, 1e-9) << where;
                expect_near(r.centre, {aside, -aside, -depth / 2}, 1e-9, where);
                EXPECT_NEAR(r.depth_lower, depth, 1e-8) << where;
                EXPECT_NEAR(r.depth_upper, depth, 1e-8) << where;
                EXPECT_GE(r.depth_upper, depth) << where;
                EXPECT_LE(r.depth_lower, depth) << where;
                EXPECT_EQ(r.count, 4u) << where;
                EXPECT_LT(r.lost, 2 * depth) << where;
                double reach = 0;
                for (const ManifoldPoint& p : m.points) {
                    EXPECT_NEAR(p.depth, depth, 1e-9) << where;
                    EXPECT_NEAR(p.point_b.z(), 0, 1e-9) << where;
                    reach += std::abs(p.point_a.x() - aside) + std::abs(p.point_a.y() + aside);
                }
                EXPECT_NEAR(reach, 4 * (half.x() + half.y()), 1e-6) << where; // the corners
            }
}

TEST(Manifolds, ABoxOnManyTrianglesIsTheSameAsOnTwo)
{
    for (const int cells : {1, 7, 40}) {
        const Two two(Shape(Box{{0.5, 0.5, 0.5}}), at(0.1, 0.2, 0.4995), flat_ground(3, cells), at(0, 0, 0));
        const Manifold m = two.manifold();
        ASSERT_EQ(m.regions.size(), 1u);
        expect_near(m.regions[0].normal, {0, 0, -1}, 1e-9, std::to_string(cells));
        EXPECT_EQ(m.regions[0].count, 4u);
        EXPECT_NEAR(m.regions[0].area, 1, 1e-9);
    }
}

TEST(Manifolds, JoinedFacesCountInTheMemoryOfAWorld)
{
    Two two(make_box_mesh({1, 1, 1}, 20), at(0, 0, 1.99), make_box_mesh({1, 1, 1}), at(0, 0, 0));
    (void)two.world.step();
    const std::size_t before = two.world.inspect().bytes;
    (void)two.manifold();
    const std::size_t after = two.world.inspect().bytes;
    EXPECT_GE(after - before, std::size_t{13 * 4800}); // neighbours and ridges of each triangle
    EXPECT_LT(after - before, std::size_t{40 * 4800});
    two.world.bodies().set_pose(two.a, at(0, 0, 1.98));
    (void)two.manifold();
    EXPECT_EQ(two.world.inspect().bytes, after);
}

TEST(Manifolds, FeaturesOfJoinedFacesAreThoseOfTheMesh)
{
    // A block of a ground and of its copy upside down below it, without sides: 196 triangles in two planes.
    Mesh block = flat_ground(3, 7);
    const auto count = static_cast<std::uint32_t>(block.vertices.size());
    for (std::uint32_t v = 0; v < count; ++v) block.vertices.push_back(block.vertices[v] - Vector3d(0, 0, 1));
    const std::vector<Triangle> top = block.triangles;
    for (const auto& [u, v, w] : top) block.triangles.push_back({u + count, w + count, v + count});
    const Mesh ground = make_mesh("block", block.vertices, block.triangles);
    // A wide box on the top meets all its corners.
    const Two two(make_box_mesh({5, 5, 0.5}), at(0, 0, 0.5), ground, at(0, 0, 0));
    std::vector<std::uint64_t> vertices;
    const Manifold wide = two.manifold();
    for (const ManifoldPoint& p : wide.points)
        if (p.feature_b >> 62 == 1) vertices.push_back(p.feature_b ^ std::uint64_t{1} << 62);
    std::ranges::sort(vertices);
    EXPECT_EQ(vertices, (std::vector<std::uint64_t>{0, 7, 56, 63}));
    const Two small(make_box_mesh({0.5, 0.5, 0.5}), at(0.1, 0.2, 0.4995), ground, at(0, 0, 0));
    const Manifold inside = small.manifold();
    EXPECT_EQ(inside.points.size(), 4u);
    for (const ManifoldPoint& p : inside.points) {
        EXPECT_EQ(p.feature_a >> 62, 1u);
        EXPECT_EQ(p.feature_b, std::uint64_t{3} << 62) << "the first triangle names the face";
    }
}

TEST(Manifolds, FacesInOnePlaneHaveTheirCommonPolygon)
{
    for (const auto& [name, make] : grounds) {
        const Two two(make_box_mesh({0.5, 0.25, 0.5}), at(0.125, 0.25, 0.5), make(), at(0, 0, -top_of(name)));
        const Manifold m = two.manifold();
        check(m, name);
        ASSERT_EQ(m.regions.size(), 1u) << name;
        const ManifoldRegion& r = m.regions[0];
        EXPECT_EQ(r.kind, RegionKind::touching) << name;
        expect_near(r.normal, {0, 0, -1}, 1e-12, name);
        EXPECT_NEAR(r.area, 0.5, 1e-9) << name;
        EXPECT_EQ(r.volume, 0) << name;
        expect_near(r.centre, {0.125, 0.25, 0}, 1e-9, name);
        EXPECT_EQ(r.count, 4u) << name;
        EXPECT_LT(r.lost, 1e-9) << name;
        EXPECT_EQ(r.depth_lower, 0) << name;
        EXPECT_LT(r.depth_upper, 1e-9) << name;
    }
    // Half on, half beside; and aligned in all faces.
    const Two over(make_box_mesh({1, 1, 1}), at(1, 0.5, 2), make_box_mesh({1, 1, 1}), at(0, 0, 0));
    ASSERT_EQ(over.manifold().regions.size(), 1u);
    EXPECT_NEAR(over.manifold().regions[0].area, 1.5, 1e-12);
    const Two aligned(make_box_mesh({1, 1, 1}), at(0, 0, 2), make_box_mesh({1, 1, 1}), at(0, 0, 0));
    ASSERT_EQ(aligned.manifold().regions.size(), 1u);
    EXPECT_NEAR(aligned.manifold().regions[0].area, 4, 1e-12);
    EXPECT_EQ(aligned.manifold().regions[0].count, 4u);
}

TEST(Manifolds, BoxesInOneColumnOverlap)
{
    for (const double depth : {0.25, 0x1p-20}) {
        const Two two(make_box_mesh({1, 1, 1}), at(0, 0, 2 - depth), Shape(Box{{1, 1, 1}}), at(0, 0, 0));
        const Manifold m = two.manifold();
        check(m, "column");
        ASSERT_EQ(m.regions.size(), 1u) << depth;
        EXPECT_EQ(m.regions[0].kind, RegionKind::crossing);
        expect_near(m.regions[0].normal, {0, 0, -1}, 1e-9, "column");
        EXPECT_NEAR(m.regions[0].volume, 4 * depth, 1e-9);
        EXPECT_NEAR(m.regions[0].depth_upper, depth, 1e-9);
    }
}

TEST(Manifolds, ABoxIsNanometresDeepInAFloorOfTenKilometres)
{
    for (const double depth : {2e-9, 1e-7}) {
        const Two two(Shape(Box{{0.5, 0.5, 0.5}}), at(3, 2, 0.5 - depth), Shape(Box{{5000, 5000, 1}}), at(0, 0, -1));
        const Manifold m = two.manifold();
        check(m, "floor");
        ASSERT_EQ(m.regions.size(), 1u);
        EXPECT_EQ(m.regions[0].kind, RegionKind::crossing) << depth;
        for (const ManifoldPoint& p : m.points) EXPECT_NEAR(p.depth, depth, 1e-10);
    }
}

TEST(Manifolds, AVertexAnEdgeAndTwoEdges)
{
    const auto tilted = [](const Vector3d& axis, double angle, double z) {
        Isometry3d pose = at(0.3, 0.2, z);
        pose.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
        return pose;
    };
    // A pyramid that touches the ground with its tip, exactly.
    const Mesh tip = make_mesh("tip", {{0, 0, 0}, {1, 0, 1}, {-0.5, 0.75, 1}, {-0.5, -0.75, 1}},
                               {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}});
    const Two vertex(tip, at(0.1, 0.2, 0), flat_ground(2, 3), at(0, 0, 0));
    ASSERT_EQ(vertex.manifold().regions.size(), 1u);
    expect_near(vertex.manifold().regions[0].normal, {0, 0, -1}, 1e-12, "vertex");
    EXPECT_EQ(vertex.manifold().regions[0].count, 1u);
    // An edge below the ground: a line.
    const Two edge(make_box_mesh({1, 0.5, 0.5}), tilted({1, 0, 0}, pi / 4, std::sqrt(0.5) - 0.01), flat_ground(4, 9),
                   at(0, 0, 0));
    const Manifold line = edge.manifold();
    check(line, "edge");
    ASSERT_EQ(line.regions.size(), 1u);
    expect_near(line.regions[0].normal, {0, 0, -1}, 1e-9, "edge");
    EXPECT_NEAR(line.regions[0].depth_upper, 0.01, 1e-9);
    // Two edges that touch in one point: the normal is across both.
    const Mesh roof_a =
        make_mesh("roof", {{-1, 0, 0}, {1, 0, 0}, {0, 1, 1}, {0, -1, 1}}, {{0, 1, 3}, {0, 2, 1}, {0, 3, 2}, {1, 2, 3}});
    const Mesh roof_b = make_mesh("roof", {{0, -1, 0}, {0, 1, 0}, {1, 0, -1}, {-1, 0, -1}},
                                  {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
    const Two edges(roof_a, at(0, 0, 0), roof_b, at(0, 0, 0));
    ASSERT_EQ(edges.manifold().regions.size(), 1u);
    expect_near(edges.manifold().regions[0].normal, {0, 0, -1}, 1e-12, "edges");
    // The same a little apart, and a tip above a face: with a margin.
    for (const auto& [upper, lower] : {std::pair(roof_a, roof_b), {tip, flat_ground(2, 3)}}) {
        const Two apart(upper, at(0.1, 0.2, 0.01), lower, at(0.1, 0.2, 0));
        const Manifold m = apart.manifold({.margin = 0.02});
        check(m, "apart");
        ASSERT_EQ(m.regions.size(), 1u);
        ASSERT_EQ(m.points.size(), 1u);
        expect_near(m.points[0].normal, {0, 0, -1}, 1e-9, "apart");
        EXPECT_NEAR(m.points[0].depth, -0.01, 1e-12);
    }
}

/// A ring around z, of 128 segments; inner = 0: a cylinder.
Mesh ring(double inner, double outer, double half)
{
    constexpr std::uint32_t n = 128;
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < n; ++i) { // of each segment: outer low and high, inner high and low
        const double angle = 2 * pi * i / n, x = std::cos(angle), y = std::sin(angle);
        for (const auto& [r, z] : {std::pair(outer, -half), {outer, half}, {inner, half}, {inner, -half}})
            vertices.emplace_back(r * x, r * y, z);
        const std::uint32_t here = 4 * i, next = 4 * ((i + 1) % n);
        for (std::uint32_t k = 0; k < 4; ++k)
            if (inner > 0 || k != 2)
                for (const Triangle& t : {Triangle{here + k, next + k, next + (k + 1) % 4},
                                          Triangle{here + k, next + (k + 1) % 4, here + (k + 1) % 4}})
                    triangles.push_back(t);
    }
    return make_mesh("ring", std::move(vertices), std::move(triangles));
}

TEST(Manifolds, PointsOnACurvedSurfaceHaveItsNormal)
{
    for (const double margin : {0.0, 0.002}) {
        const Two two(ring(0.505, 1, 0.25), at(0, 0, 0), ring(0, 0.5, 0.5), at(0.006, 0, 0)); // an arc of 67 degrees
        const Manifold m = two.manifold({.margin = margin});
        check(m, "shaft");
        EXPECT_GT(m.points.size(), 8u);
        for (const ManifoldPoint& p : m.points) {
            const Vector3d inward(-p.point_a.x(), -p.point_a.y(), 0);
            EXPECT_GT(p.normal.dot(inward.normalized()), std::cos(0.05)) << margin << ": " << p.point_a.transpose();
        }
    }
}

TEST(Manifolds, PointsOnAFlatSurfaceHaveTheNormalOfTheRegion)
{
    for (const double angle : {0.0, 1e-7, 1e-5}) {
        Isometry3d pose = at(0.1, 0.2, 0.4999);
        pose.linear() = Eigen::AngleAxisd(angle, Vector3d(1, 2, 0).normalized()).toRotationMatrix();
        const Two two(make_box_mesh({0.5, 0.5, 0.5}), pose, make_box_mesh({2, 2, 1}), at(0, 0, -1));
        const Manifold m = two.manifold();
        ASSERT_EQ(m.regions.size(), 1u);
        EXPECT_EQ(m.points.size(), 4u);
        for (const ManifoldPoint& p : m.points) EXPECT_EQ(p.normal, m.regions[0].normal) << angle;
    }
}

TEST(Manifolds, EnclosedBodiesLeaveThroughTheNearestSurface)
{
    const std::pair<const char*, GeometryData> inner[] = {{"mesh", make_box_mesh({0.25, 0.25, 0.25})},
                                                          {"box", Shape(Box{{0.25, 0.25, 0.25}})},
                                                          {"sphere", Shape(Sphere{0.25})}};
    for (const auto& [name, body] : inner) {
        const Two two(body, at(1.5, 0.2, 0.1), make_box_mesh({2, 2, 2}), at(0, 0, 0));
        const Manifold m = two.manifold();
        check(m, name);
        ASSERT_EQ(m.regions.size(), 1u) << name;
        EXPECT_EQ(m.regions[0].kind, RegionKind::enclosed) << name;
        expect_near(m.regions[0].normal, {-1, 0, 0}, 1e-2, name); // b moves to -x, so that a leaves to +x
        EXPECT_GE(m.regions[0].depth_upper, 0.75 - 1e-9) << name;
        EXPECT_NEAR(m.regions[0].depth_lower, 0.25, 1e-2) << name;
    }
    const Two below(make_box_mesh({0.25, 0.25, 0.25}), at(0.3, 0.2, -1), Shape(HalfSpace{}), at(0, 0, 0));
    ASSERT_EQ(below.manifold().regions.size(), 1u);
    EXPECT_EQ(below.manifold().regions[0].kind, RegionKind::enclosed);
    expect_near(below.manifold().regions[0].normal, {0, 0, -1}, 1e-9, "half-space");
    EXPECT_NEAR(below.manifold().regions[0].depth_upper, 1.25, 1e-9);
}

/// The middle of the cell is in the ball, and the ball in the cell.
TEST(Manifolds, ABallInACellIsWhatLeaves)
{
    OccupancyMap map = tools::one_cell(1);
    const Vector3d middle(0.5, 0.5, 0.5);
    map.set(std::vector{middle}, CellState::occupied);
    const Vector3d at_ball(0.5, 0.5, 0.6);
    const Two two(map, at(0, 0, 0), Shape(Sphere{0.25}), at(0.5, 0.5, 0.6));
    const Manifold m = two.manifold();
    ASSERT_EQ(m.regions.size(), 1u);
    EXPECT_EQ(m.regions[0].kind, RegionKind::enclosed);
    expect_near(m.regions[0].normal, {0, 0, 1}, 1e-2, "up");
    EXPECT_NEAR((m.points[0].point_b - at_ball).norm(), 0.25, 1e-9);
    EXPECT_NEAR(m.regions[0].depth_upper, 0.65, 1e-2);
}

TEST(Manifolds, WhatHasNoNormalSaysSo)
{
    const Two rod(make_box_mesh({0.1, 0.1, 2}), at(0.01, 0.02, 0.1), make_box_mesh({2, 2, 0.05}), at(0, 0, 0));
    check(rod.manifold(), "rod");
    ASSERT_EQ(rod.manifold().regions.size(), 1u);
    EXPECT_EQ(rod.manifold().regions[0].normal_error, pi);
    EXPECT_NEAR(rod.manifold().regions[0].volume, 0.2 * 0.2 * 0.1, 1e-12);
    const Mesh knot = make_torus_knot_mesh(2, 3, 0.4, 0.2, 0.08, 600);
    const Two same(knot, at(0, 0, 0), knot, at(0, 0, 0));
    check(same.manifold(), "copies");
    EXPECT_FALSE(same.manifold().regions.empty());
    const Two sheets(flat_ground(1, 3), at(0, 0, 0), flat_ground(1, 2),
                     Isometry3d(Eigen::AngleAxisd(1, Vector3d::UnitX())));
    check(sheets.manifold(), "sheets");
    ASSERT_FALSE(sheets.manifold().regions.empty());
    EXPECT_TRUE(sheets.manifold().regions[0].open);
    EXPECT_EQ(sheets.manifold().regions[0].normal_error, pi);
    const Two planes(Shape(HalfSpace{}), at(0, 0, 0), Shape(HalfSpace{}), at(0, 0, 1));
    EXPECT_FALSE(planes.manifold().complete);
}

TEST(Manifolds, RoundShapesOnPlanes)
{
    struct Case {
        const char* name;
        Shape shape;
        double height;
        std::uint32_t points;
        bool turned;
    };
    const Case cases[] = {
        {"sphere", Sphere{0.5}, 0.5, 1, false},        {"capsule", Capsule{0.25, 1}, 0.25, 2, true},
        {"cylinder", Cylinder{0.5, 1}, 0.5, 4, false}, {"lying cylinder", Cylinder{0.25, 1}, 0.25, 2, true},
        {"cone", Cone{0.5, 1}, 0.5, 4, false},         {"ellipsoid", Ellipsoid{{0.3, 0.4, 0.5}}, 0.5, 1, false}};
    for (const Case& c : cases)
        for (const auto& [name, make] : grounds) {
            const std::string where = std::string(c.name) + " on " + name;
            Isometry3d pose = at(0.13, 0.27, c.height - 0.01);
            if (c.turned) pose.linear() = Eigen::AngleAxisd(pi / 2, Vector3d::UnitY()).toRotationMatrix();
            const Two two(c.shape, pose, make(), at(0, 0, -top_of(name)));
            const Manifold m = two.manifold();
            check(m, where);
            ASSERT_EQ(m.regions.size(), 1u) << where;
            expect_near(m.regions[0].normal, {0, 0, -1}, 1e-6, where);
            EXPECT_EQ(m.regions[0].count, c.points) << where;
            for (const ManifoldPoint& p : m.points) EXPECT_NEAR(p.depth, 0.01, 1e-6) << where;
            EXPECT_GE(m.regions[0].depth_upper, 0.01 - 1e-12) << where;
        }
}

TEST(Manifolds, TwoRoundShapes)
{
    const Two spheres(Shape(Sphere{0.5}), at(0, 0, 0), Shape(Sphere{0.25}), at(0.6, 0.4, 0));
    const Manifold m = spheres.manifold();
    check(m, "spheres");
    ASSERT_EQ(m.regions.size(), 1u);
    expect_near(m.regions[0].normal, Vector3d(0.6, 0.4, 0).normalized(), 1e-4, "spheres");
    EXPECT_NEAR(m.points[0].depth, 0.75 - std::hypot(0.6, 0.4), 1e-6);
    const Two capsules(Shape(Capsule{0.25, 1}), at(0, 0, 0), Shape(Capsule{0.25, 1}), at(0.49, 0, 0.25));
    const Manifold lines = capsules.manifold();
    ASSERT_EQ(lines.regions.size(), 1u);
    EXPECT_EQ(lines.regions[0].count, 2u);
    expect_near(lines.regions[0].normal, Vector3d::UnitX(), 1e-4, "capsules");
    EXPECT_TRUE(Two(Shape(Sphere{0.5}), at(0, 0, 0), Shape(Sphere{0.25}), at(0, 0, 0.8)).manifold().regions.empty());
}

TEST(Manifolds, AMarginGivesPointsApart)
{
    for (const auto& [name, make] : grounds) {
        if (std::string_view(name) == "map") continue;
        const Two two(make_box_mesh({0.5, 0.5, 0.5}), at(0.1, 0.2, 0.51), make(), at(0, 0, -top_of(name)));
        EXPECT_TRUE(two.manifold().regions.empty()) << name;
        const Manifold m = two.manifold({.margin = 0.02});
        check(m, name);
        ASSERT_EQ(m.regions.size(), 1u) << name;
        EXPECT_EQ(m.regions[0].kind, RegionKind::near) << name;
        expect_near(m.regions[0].normal, {0, 0, -1}, 1e-9, name);
        EXPECT_EQ(m.regions[0].count, 4u) << name;
        for (const ManifoldPoint& p : m.points) EXPECT_NEAR(p.depth, -0.01, 1e-9) << name;
    }
    const Two sphere(Shape(Sphere{0.5}), at(0.1, 0.2, 0.51), flat_ground(3, 10), at(0, 0, 0));
    const Manifold m = sphere.manifold({.margin = 0.02});
    check(m, "sphere");
    ASSERT_EQ(m.regions.size(), 1u);
    expect_near(m.regions[0].normal, {0, 0, -1}, 1e-6, "sphere");
    EXPECT_NEAR(m.points[0].depth, -0.01, 1e-9);
}

} // namespace
} // namespace oncollide::manifold_scenes
