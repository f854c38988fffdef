// Insides that overlap although all pairs of triangles only touch.
#include <array>
#include <set>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/inside/shared_inside.hpp>
#include <oncollide/samples/generators.hpp>

#include "narrowphase/mesh_parts.hpp"
#include "random_pose.hpp"

namespace oncollide {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Cell = std::array<int, 3>;
using Cells = std::set<Cell>;

/// The surface of unit cubes joined by their faces, two triangles per face of a cube.
Mesh mesh_of(const Cells& cells)
{
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (const Cell& cell : cells)
        for (int axis = 0; axis < 3; ++axis)
            for (int side = 0; side < 2; ++side) {
                Cell next = cell;
                next[std::size_t(axis)] += side ? 1 : -1;
                if (cells.contains(next)) continue;
                const auto first = std::uint32_t(vertices.size());
                for (const auto& [u, v] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)}) {
                    Vector3d corner(cell[0], cell[1], cell[2]);
                    corner[axis] += side, corner[(axis + 1) % 3] += u, corner[(axis + 2) % 3] += v;
                    vertices.push_back(corner);
                }
                for (Triangle t : {Triangle{0, 1, 2}, Triangle{0, 2, 3}}) {
                    if (!side) std::swap(t[1], t[2]);
                    triangles.push_back({first + t[0], first + t[1], first + t[2]});
                }
            }
    return make_mesh("cubes", std::move(vertices), std::move(triangles));
}

/// Grown from one cube; its mesh is closed.
Cells random_cells(std::uint64_t seed, std::size_t count)
{
    Cells cells{{0, 0, 0}};
    for (std::uint64_t step = 0; cells.size() < count; ++step) {
        auto from = cells.begin();
        std::advance(from, int(u01(seed, step, 0) * double(cells.size())));
        Cell next = *from;
        next[std::size_t(u01(seed, step, 1) * 3)] += u01(seed, step, 2) < 0.5 ? 1 : -1;
        if (!cells.insert(next).second) continue;
        if (!is_closed(mesh_of(cells))) cells.erase(next); // cubes that meet only at an edge
    }
    return cells;
}

TriangleContact contact(const Mesh& a, const Mesh& b, const RelativePose& b_to_a)
{
    ObbTree tree_a(a), tree_b(b);
    return Traversal().contact(tree_a, tree_b, b_to_a).kind;
}

bool found(const Mesh& a, const Mesh& b, const RelativePose& b_to_a)
{
    ObbTree tree_a(a), tree_b(b);
    SharedInside inside;
    const auto point = inside.find(tree_a, tree_b, b_to_a);
    std::vector<TrianglePair> pairs;
    Traversal().all_meeting(tree_a, tree_b, b_to_a, pairs);
    if (pairs.size() > 50) pairs.resize(50);
    for (const TrianglePair& pair : pairs)
        EXPECT_LE(inside.is_beside(tree_a, tree_b, b_to_a, pair), point.has_value()) << pair.a << ' ' << pair.b;
    if (!point) return false;
    EXPECT_EQ(std::abs(std::round(winding_number(a, *point))), 1) << point->transpose();
    return true;
}

bool found(const Mesh& a, const Mesh& b, const Vector3d& by)
{
    Isometry3d pose = Isometry3d::Identity();
    pose.translation() = by;
    return found(a, b, RelativePose(Isometry3d::Identity(), pose));
}

TEST(SharedInside, OfCubesIsACubeOfBoth)
{
    int overlap = 0, apart = 0;
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
        const Cells a = random_cells(2 * seed, 2 + seed % 7), b = random_cells(2 * seed + 1, 1 + seed % 5);
        Cell by;
        for (std::uint64_t k = 0; k < 3; ++k) by[k] = int(u01(seed, 7, k) * 5) - 2;
        bool common = false;
        for (const Cell& c : b) common |= a.contains({c[0] + by[0], c[1] + by[1], c[2] + by[2]});
        const Mesh mesh_a = seed % 3 ? mesh_of(a) : flipped(mesh_of(a)), mesh_b = mesh_of(b);
        Isometry3d pose = Isometry3d::Identity();
        pose.translation() = Vector3d(by[0], by[1], by[2]);
        const RelativePose b_to_a(Isometry3d::Identity(), pose);
        const TriangleContact how = contact(mesh_a, mesh_b, b_to_a);
        if (how == TriangleContact::separate) continue;
        if (how == TriangleContact::crossing) {
            EXPECT_TRUE(common) << seed;
            continue;
        }
        ++(common ? overlap : apart);
        EXPECT_EQ(found(mesh_a, mesh_b, b_to_a), common) << seed;
    }
    EXPECT_GT(overlap, 80);
    EXPECT_GT(apart, 80);
}

TEST(SharedInside, IsFoundBelowAnEdgeThatLiesInAFace)
{
    const Mesh box = make_box_mesh({1, 1, 1});
    for (const double wide : {0.9, 0.1, 0.01})
        for (const double base : {0.5, 1.5}) { // a roof inside the box, or above it on its ridge
            const Mesh roof =
                make_mesh("roof",
                          {{-0.5, -wide, base},
                           {0.5, -wide, base},
                           {0.5, wide, base},
                           {-0.5, wide, base},
                           {-0.5, 0, 1},
                           {0.5, 0, 1}},
                          {{0, 2, 1}, {0, 3, 2}, {0, 5, 4}, {0, 1, 5}, {2, 4, 5}, {2, 3, 4}, {0, 4, 3}, {1, 2, 5}});
            ASSERT_TRUE(is_closed(roof));
            const RelativePose stay(Isometry3d::Identity(), Isometry3d::Identity());
            EXPECT_EQ(contact(box, roof, stay), TriangleContact::touching);
            EXPECT_EQ(found(box, roof, stay), base < 1) << wide;
            EXPECT_EQ(found(roof, box, stay), base < 1) << wide;
        }
}

TEST(SharedInside, IsNoneWhereBodiesFitExactly)
{
    Cells frame, peg{{1, 1, 0}};
    for (int x = 0; x < 3; ++x)
        for (int y = 0; y < 3; ++y)
            if (x != 1 || y != 1) frame.insert({x, y, 0});
    EXPECT_FALSE(found(mesh_of(frame), mesh_of(peg), {0, 0, 0}));
    EXPECT_TRUE(found(mesh_of(frame), mesh_of(peg), {0x1p-30, 0, 0}));
    EXPECT_FALSE(found(mesh_of(frame), mesh_of(peg), {0, 0, 1}));
    EXPECT_TRUE(found(mesh_of(frame), mesh_of(frame), {0, 0, 0}));
}

/// A cylinder whose caps are fans around a centre vertex.
Mesh fan_cylinder(std::uint32_t segments, double turn = 0)
{
    std::vector<Vector3d> vertices{{0, 0, 0}, {0, 0, 1}};
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < segments; ++i) {
        const double angle = 2 * 3.141592653589793 * (i + turn) / segments;
        for (const double z : {0.0, 1.0}) vertices.emplace_back(std::cos(angle), std::sin(angle), z);
        const std::uint32_t low = 2 + 2 * i, next = 2 + 2 * ((i + 1) % segments);
        triangles.insert(triangles.end(),
                         {{0, next, low}, {1, low + 1, next + 1}, {low, next, next + 1}, {low, next + 1, low + 1}});
    }
    return make_mesh("cylinder", std::move(vertices), std::move(triangles));
}

Isometry3d above(double height)
{
    Isometry3d pose = Isometry3d::Identity();
    pose.translation().z() = height;
    return pose;
}

TEST(SharedInside, LooksAtNoPairsOfFansWhereAPlanePartsStackedCylinders)
{
    for (const double turn : {0.0, 0.5, 0.3}) {
        const Mesh low = fan_cylinder(512), high = fan_cylinder(512, turn);
        ASSERT_TRUE(is_closed(low));
        const RelativePose b_to_a(Isometry3d::Identity(), above(1));
        ObbTree a(low), b(high);
        Traversal walk;
        const Traversal::Contact contact = walk.contact(a, b, b_to_a);
        EXPECT_TRUE(contact.parted) << turn;
        EXPECT_EQ(contact.kind, TriangleContact::touching);
        EXPECT_LT(walk.counts().triangles, 1000u) << "of 262,144 pairs that meet";
        SharedInside inside;
        EXPECT_FALSE(inside.find(a, b, b_to_a));
        EXPECT_EQ(inside.points_placed(), 0u);
    }
}

TEST(SharedInside, LooksAtNoPairsOfFansWhereAPlanePartsStackedGears)
{
    const Mesh gear = make_gear_mesh(100, 0.9, 1, 0.5, 0.3);
    Isometry3d rotated = above(0.5);
    rotated.rotate(Eigen::AngleAxisd(0.01, Vector3d::UnitZ()));
    const RelativePose b_to_a(Isometry3d::Identity(), rotated);
    ObbTree a(gear), b(gear);
    EXPECT_TRUE(Traversal().contact(a, b, b_to_a).parted);
    SharedInside inside;
    EXPECT_FALSE(inside.find(a, b, b_to_a));
    EXPECT_EQ(inside.points_placed(), 0u);
}

/// Two fans touch at their centres, and a hook around them prevents any separating plane.
TEST(SharedInside, TriesEachFaceOnceAroundAPointThatManyPairsShare)
{
    constexpr std::uint32_t segments = 64;
    const Mesh low = fan_cylinder(segments);
    // B: an inverted cone on A's cap, and a box beside A.
    std::vector<Vector3d> vertices{{0, 0, 1}, {0, 0, 2}};
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < segments; ++i) {
        const double angle = 2 * 3.141592653589793 * i / segments;
        vertices.emplace_back(std::cos(angle), std::sin(angle), 2);
        const std::uint32_t here = 2 + i, next = 2 + (i + 1) % segments;
        triangles.insert(triangles.end(), {{0, next, here}, {1, here, next}});
    }
    const Mesh box = make_box_mesh({0.1, 0.1, 0.1});
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (const Vector3d& v : box.vertices) vertices.push_back(v + Vector3d(3, 0, 0));
    for (const Triangle& t : box.triangles) triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    const Mesh cone = make_mesh("cone and box", std::move(vertices), std::move(triangles));
    const RelativePose stay(Isometry3d::Identity(), Isometry3d::Identity());
    ObbTree a(low), b(cone);
    Traversal walk;
    const Traversal::Contact contact = walk.contact(a, b, stay);
    EXPECT_FALSE(contact.parted);
    EXPECT_EQ(contact.kind, TriangleContact::touching);
    SharedInside inside;
    EXPECT_FALSE(inside.find(a, b, stay));
    EXPECT_GT(inside.points_placed(), 0u);
    EXPECT_LE(inside.points_placed(), 4u * segments) << "two a face, where " << segments * segments << " pairs meet";
}

/// A sphere inside a box, with vertices on its walls: surfaces meet only at points.
TEST(SharedInside, IsFoundWhereBodiesTouchInAPoint)
{
    const Mesh box = make_box_mesh({1, 1, 1}), ball = make_sphere_mesh(1, 128);
    EXPECT_TRUE(found(box, ball, {0, 0, 0}));
    EXPECT_TRUE(found(ball, box, {0, 0, 0}));
    EXPECT_FALSE(found(box, ball, {0, 0, 2}));
    EXPECT_TRUE(found(box, transformed("small", ball, 0.125, {0, 0, 0}), {0.25, 0.125, 0.875}));
    EXPECT_FALSE(found(box, transformed("small", ball, 0.125, {0, 0, 0}), {0.25, 0.125, 1.125}));
}

TEST(SharedInside, IsFoundInTwinsAtAnyPoseAndScale)
{
    for (const double scale : {1e-6, 1.0, 1e6})
        for (std::uint64_t seed = 0; seed < 10; ++seed) {
            Mesh knot = make_torus_knot_mesh(2, 3, scale, 0.4 * scale, 0.15 * scale, 200);
            const Isometry3d pose = random_pose(seed, 10 * scale);
            EXPECT_TRUE(found(knot, knot, RelativePose(pose, pose))) << scale << ' ' << seed;
        }
}

} // namespace
} // namespace oncollide
