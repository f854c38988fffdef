// Penetration depths, compared with bodies whose depth is known.
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include <oncollide/narrowphase/model.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/geometry.hpp>
#include <oncollide/scenes/model/box_corners.hpp>

#include "random_pose.hpp"

namespace oncollide::penetration_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Isometry3d at(double x, double y = 0, double z = 0)
{
    return Isometry3d(Eigen::Translation3d(x, y, z));
}

Penetration between(const GeometryData& a, const Isometry3d& pose_a, const GeometryData& b, const Isometry3d& pose_b,
                    int threads = 1)
{
    World world({.exact = ExactLevel::predicates, .threads = threads});
    const auto add = [&](const GeometryData& data, const Isometry3d& pose) {
        const ModelId model = world.models().add(std::make_shared<const Geometry>(Geometry{"", data, ""}));
        return world.bodies().add({.model = model, .pose = pose});
    };
    const BodyId first = add(a, pose_a);
    const PairOfBodies pair{first, add(b, pose_b)};
    Penetration found;
    world.pairs().penetration(std::span(&pair, 1), {&found, 1});
    return found;
}

const Mesh cube = make_box_mesh({1, 1, 1});

void expect_box(const Aabb& box, const Vector3d& min, const Vector3d& max, double off = 1e-12)
{
    EXPECT_LT((box.min - min).norm(), off) << box.min.transpose();
    EXPECT_LT((box.max - max).norm(), off) << box.max.transpose();
}

TEST(Penetration, TheCornerOfABoxInAnother)
{
    const Penetration p = between(cube, at(0), cube, at(1.9, 1.8, 1.5));
    expect_box(p.contact, {0.9, 0.8, 0.5}, {1, 1, 1});
    expect_box(p.overlap, {0.9, 0.8, 0.5}, {1, 1, 1});
    EXPECT_NEAR(p.depth, 0.1, 1e-9);
    EXPECT_NEAR(p.thickness, 0.1, 1e-12);
    EXPECT_NEAR(std::abs(p.thin_along.x()), 1, 1e-12);
    EXPECT_LE(p.depth, 0.1);
}

TEST(Penetration, TheSameWhereverTheBodiesAreTurned)
{
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const Isometry3d pose = random_pose(seed, 3);
        const Penetration p = between(cube, pose, cube, pose * at(1.9, 1.8, 1.5));
        EXPECT_NEAR(p.depth, 0.1, 1e-9);
        EXPECT_NEAR(p.thickness, 0.1, 1e-9) << "the normals show along which direction it is thin";
        EXPECT_LT((pose.inverse() * p.deepest - Vector3d(p.of_a ? 1 : 0.9, p.of_a ? 1 : 0.8, p.of_a ? 1 : 0.5)).norm(),
                  1e-9);
    }
}

TEST(Penetration, BarsThatCrossHaveNoVertexInside)
{
    const Mesh bar = make_box_mesh({5, 0.5, 0.5}), other = make_box_mesh({0.4, 5, 0.3});
    const Penetration p = between(bar, at(0), other, at(0));
    EXPECT_EQ(p.depth, 0);
    expect_box(p.overlap, {-0.4, -0.5, -0.3}, {0.4, 0.5, 0.3});
    EXPECT_NEAR(p.thickness, 0.6, 1e-12);
}

TEST(Penetration, ABallWhollyInsideIsAsDeepAsItsDeepestVertex)
{
    const Mesh ball = make_sphere_mesh(0.25, 512), crate = make_box_mesh({2, 3, 4});
    const Penetration p = between(crate, at(0), ball, at(1, 0, 0));
    EXPECT_TRUE(p.contact.empty());
    EXPECT_FALSE(p.of_a);
    // The deepest vertex is the one farthest from the wall at x = 2.
    EXPECT_LE(p.depth, 1.25);
    EXPECT_GE(p.depth, 1.25 / 1.02);
    expect_box(p.overlap, {0.75, -0.25, -0.25}, {1.25, 0.25, 0.25});
}

TEST(Penetration, NothingWhereBodiesTouchOrAreApart)
{
    for (const double x : {2.0, 2.5}) {
        const Penetration p = between(cube, at(0), cube, at(x));
        EXPECT_EQ(p.depth, 0);
        EXPECT_EQ(p.contact.empty(), x > 2);
        EXPECT_EQ(x == 2 ? p.thickness : 0, 0);
    }
}

TEST(Penetration, ACavityIsNoInside)
{
    // A crate with a hollow, in which a sphere is free.
    Mesh hollow = make_box_mesh({2, 2, 2});
    const Mesh inner = make_box_mesh({1, 1, 1});
    for (const Triangle& t : inner.triangles) hollow.triangles.push_back({t[0] + 8, t[2] + 8, t[1] + 8});
    hollow.vertices.insert(hollow.vertices.end(), inner.vertices.begin(), inner.vertices.end());
    hollow = make_mesh("hollow", hollow.vertices, hollow.triangles);
    EXPECT_EQ(between(hollow, at(0), make_sphere_mesh(0.5, 128), at(0)).depth, 0);
    EXPECT_NEAR(between(hollow, at(0), make_sphere_mesh(0.5, 128), at(1.5)).depth, 0.5, 0.01);
}

TEST(Penetration, OpenSurfacesHaveAContactCurveAndNoThickness)
{
    const Mesh sheet = make_mesh("sheet", {{-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}}, {{0, 1, 2}, {0, 2, 3}});
    const Penetration p = between(sheet, at(0), cube, at(0, 0, 0.5));
    expect_box(p.contact, {-1, -1, 0}, {1, 1, 0});
    EXPECT_EQ(p.thickness, std::numeric_limits<double>::infinity());
    EXPECT_EQ(p.depth, 0);
}

TEST(Penetration, DeepestIsDeepestOfThousandsAndEqualForAnyThreads)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.2, 4000), ball = make_sphere_mesh(1, 2000);
    const Penetration p = between(knot, at(0), ball, at(0.3, 0.2, 0.1));
    double deepest = 0;
    for (const Vector3d& v : knot.vertices) deepest = std::max(deepest, 1 - (v - Vector3d(0.3, 0.2, 0.1)).norm());
    // The sphere's facets are up to 0.3 % inside the ideal sphere; its own vertices may be deeper in the knot's tube.
    EXPECT_GT(p.depth, deepest / 1.01 - 0.01);
    EXPECT_LT(p.depth, std::max(deepest, 0.2) + 1e-9);
    const Penetration again = between(knot, at(0), ball, at(0.3, 0.2, 0.1), 4);
    EXPECT_EQ(again.depth, p.depth);
    EXPECT_EQ(again.thickness, p.thickness);
}

TEST(Penetration, BoxesAndHullsCountAsTheirSurfaces)
{
    EXPECT_NEAR(between(Shape(Box{{1, 1, 1}}), at(0), cube, at(1.9, 1.8, 1.5)).depth, 0.1, 1e-9);
}

/// A body with its depth at a point of its own frame, which is negative outside.
struct Known {
    const char* name;
    GeometryData data;
    std::function<double(const Vector3d&)> depth;
};

const Vector3d half(0.5, 0.75, 1);

double depth_in_box(const Vector3d& p)
{
    return (half - p.cwiseAbs()).minCoeff();
}

OccupancyMap box_map()
{
    std::vector<MapCell> cells;
    for (int x = -2; x < 2; ++x)
        for (int y = -3; y < 3; ++y)
            for (int z = -4; z < 4; ++z) cells.push_back({x, y, z, 1});
    return make_occupancy_map("block", 0.25, cells);
}

std::vector<Known> bounded_bodies()
{
    ConvexHull hull;
    for (unsigned k = 0; k < 8; ++k) hull.points.push_back(corner_of(Aabb{-half, half}, k));
    const auto across = [](const Vector3d& p) { return std::hypot(p.x(), p.y()); };
    return {{"box", Shape(Box{half}), depth_in_box},
            {"hull", Shape(hull), depth_in_box},
            {"mesh", make_box_mesh(half), depth_in_box},
            {"map", box_map(), depth_in_box},
            {"sphere", Shape(Sphere{0.8}), [](const Vector3d& p) { return 0.8 - p.norm(); }},
            {"capsule", Shape(Capsule{0.4, 1}),
             [](const Vector3d& p) { return 0.4 - (p - Vector3d(0, 0, std::clamp(p.z(), -0.5, 0.5))).norm(); }},
            {"cylinder", Shape(Cylinder{0.6, 1.4}),
             [=](const Vector3d& p) { return std::min(0.6 - across(p), 0.7 - std::abs(p.z())); }},
            {"cone", Shape(Cone{0.7, 1.6}), [=](const Vector3d& p) {
                 return std::min(p.z() + 0.8, (0.7 * (0.8 - p.z()) - 1.6 * across(p)) / std::hypot(0.7, 1.6));
             }}};
}

TEST(Penetration, BoundsTheDeepestPointOfAllPairsOfBoundedBodies)
{
    const std::vector<Known> bodies = bounded_bodies();
    int deep = 0, apart = 0, narrow = 0;
    for (std::uint64_t seed = 0; seed < 8; ++seed)
        for (const Known& a : bodies)
            for (const Known& b : bodies) {
                SCOPED_TRACE(testing::Message() << a.name << " " << b.name << " at " << seed);
                const Isometry3d pose_a = random_pose(3 * seed, 5);
                Isometry3d pose_b = random_pose(3 * seed + 1, 1.2);
                pose_b.translation() += pose_a.translation();
                const Penetration p = between(a.data, pose_a, b.data, pose_b);
                ASSERT_TRUE(p.supported);
                // The deepest of a grid of points of both bodies.
                double deepest = 0;
                constexpr double step = 0.1;
                const Isometry3d into_b = pose_b.inverse() * pose_a;
                for (double x = -1; x <= 1; x += step)
                    for (double y = -1; y <= 1; y += step)
                        for (double z = -1.3; z <= 1.3; z += step) {
                            const Vector3d at_a(x, y, z);
                            const double of_a = a.depth(at_a), of_b = of_a < 0 ? -1 : b.depth(into_b * at_a);
                            if (of_b >= 0) deepest = std::max({deepest, of_a, of_b});
                        }
                EXPECT_LE(p.depth, p.depth_upper);
                EXPECT_GE(p.depth_upper, deepest - 1e-9);
                EXPECT_LE(p.depth, deepest + 1.5 * step);
                if (p.depth > 0) {
                    const double of_a = a.depth(pose_a.inverse() * p.deepest),
                                 of_b = b.depth(pose_b.inverse() * p.deepest);
                    EXPECT_GE(p.of_a ? of_a : of_b, -1e-9) << "a point of its body";
                    EXPECT_GE(p.of_a ? of_b : of_a, p.depth - 1e-9) << "this deep in the other";
                }
                deep += p.depth > 0.1, apart += p.depth_upper == 0, narrow += p.depth > 0.5 * p.depth_upper;
                const Penetration back = between(b.data, pose_b, a.data, pose_a);
                EXPECT_NEAR(back.depth, p.depth, 0.02 * p.depth + 1e-9);
            }
    EXPECT_GT(deep, 100);
    EXPECT_GT(apart, 50);
    EXPECT_GT(narrow, 100);
}

Terrain flat_terrain()
{
    TerrainGrid grid{.columns = 41, .rows = 41};
    grid.spacing = {0.5, 0.5}, grid.origin = {-10, -10, 0};
    return make_terrain("flat", grid, std::vector<double>(41 * 41, 0.0));
}

TEST(Penetration, OfAHalfSpaceIsThatOfTheLowestPoint)
{
    for (std::uint64_t seed = 0; seed < 20; ++seed)
        for (const Known& body : bounded_bodies()) {
            SCOPED_TRACE(testing::Message() << body.name << " at " << seed);
            const Isometry3d ground = random_pose(2 * seed, 3), pose = random_pose(2 * seed + 1, 1);
            const Model model(std::make_shared<const Geometry>(Geometry{"", body.data, ""}));
            double lowest = std::numeric_limits<double>::infinity();
            if (model.kind() == Kind::round) {
                const Convex& c = model.convex();
                lowest = (pose * c.support(pose.linear().transpose() * -Vector3d::UnitZ())).z() - c.radius;
            } else {
                for (unsigned k = 0; k < 8; ++k)
                    lowest = std::min(lowest, (pose * corner_of(Aabb{-half, half}, k)).z());
            }
            const double depth = std::max(-lowest, 0.0);
            const Penetration p = between(Shape(HalfSpace{}), ground, body.data, ground * pose);
            EXPECT_NEAR(p.depth, depth, 1e-9);
            EXPECT_NEAR(p.depth_upper, depth, 1e-9);
            EXPECT_LE(p.depth, depth + 1e-14);
            EXPECT_GE(p.depth_upper, depth - 1e-14);
            if (depth > 0) {
                EXPECT_FALSE(p.of_a);
            }
            EXPECT_EQ(between(body.data, ground * pose, Shape(HalfSpace{}), ground).depth, p.depth);
            // The same of a flat terrain, which is solid below its surface.
            const Penetration on_terrain = between(flat_terrain(), ground, body.data, ground * pose);
            EXPECT_LE(on_terrain.depth, depth + 1e-9);
            EXPECT_GE(on_terrain.depth_upper, depth - 1e-9);
            EXPECT_LE(on_terrain.depth_upper, depth + 1e-4);
            EXPECT_GE(on_terrain.depth, (std::string_view(body.name) == "map" ? 0.5 : 0.99) * depth - 0.13);
        }
}

TEST(Penetration, OfASphereIsTheRadiusLessTheDistanceOfItsCentreWhateverTheWallIs)
{
    std::vector<Known> walls = bounded_bodies();
    walls.resize(4); // their highest points are at z = 1
    walls.push_back(
        {"sheet", make_mesh("sheet", {{-9, -9, 1}, {9, -9, 1}, {9, 9, 1}, {-9, 9, 1}}, {{0, 1, 2}, {0, 2, 3}}), {}});
    for (const Known& wall : walls)
        for (const Shape& round : {Shape(Sphere{1}), Shape(Capsule{1, 0.5})}) {
            SCOPED_TRACE(wall.name);
            const double below = std::holds_alternative<Capsule>(round) ? 0.25 : 0;
            const Isometry3d pose = random_pose(7, 4);
            const Penetration p = between(wall.data, pose, round, pose * at(0.1, 0.2, 1.4 + below));
            EXPECT_NEAR(p.depth, 0.6, 1e-9);
            EXPECT_NEAR(p.depth_upper, 0.6, 1e-9);
            EXPECT_TRUE(p.of_a);
            EXPECT_NEAR((pose.inverse() * p.deepest - Vector3d(0.1, 0.2, 1)).norm(), 0, 1e-6);
            EXPECT_EQ(between(wall.data, pose, round, pose * at(0.1, 0.2, 2.1 + below)).depth_upper, 0);
        }
}

TEST(Penetration, OfBodiesSunkIntoATerrainIsMeasuredBelowItsSurface)
{
    TerrainGrid grid{.columns = 21, .rows = 21};
    grid.spacing = {1, 1}, grid.origin = {-10, -10, 0};
    std::vector<double> heights;
    for (int y = 0; y < 21; ++y)
        for (int x = 0; x < 21; ++x) heights.push_back(0.25 * ((x * 7 + y * 5) % 4));
    const Terrain hills = make_terrain("hills", grid, heights);
    for (const Known& body : bounded_bodies()) {
        SCOPED_TRACE(body.name);
        const Penetration p = between(hills, at(0), body.data, at(0.3, 0.4, -3));
        EXPECT_GE(p.depth, 2.3) << "wholly below the surface";
        EXPECT_LE(p.depth, p.depth_upper);
        EXPECT_LE(p.depth_upper, 4.9);
        EXPECT_EQ(between(hills, at(0), body.data, at(0.3, 0.4, 2.5)).depth, 0);
        EXPECT_EQ(between(hills, at(0), body.data, at(30, 0, -3)).depth_upper, 0) << "beside it";
    }
}

/// The least translation that parts two shapes is within 1 %.
TEST(Penetration, OfTwoShapesHasTheirLeastTranslation)
{
    const auto expect = [](const Shape& a, const Isometry3d& pose_a, const Shape& b, const Isometry3d& pose_b,
                           double length, const Vector3d& along) {
        const Penetration p = between(a, pose_a, b, pose_b), q = between(b, pose_b, a, pose_a);
        EXPECT_LE(p.parting_lower, length * (1 + 1e-12));
        EXPECT_GE(p.parting_upper, length * (1 - 1e-12));
        EXPECT_LE(p.parting_upper, 1.01 * p.parting_lower + 1e-12);
        EXPECT_LT((p.parting_along - along).norm(), 1e-6) << p.parting_along.transpose();
        EXPECT_EQ(p.parting_along, -q.parting_along);
        EXPECT_EQ(p.parting_upper, q.parting_upper);
        EXPECT_LE(p.depth, p.parting_upper);
    };
    // Flat cylinders that slide over each other, 5 cm deep.
    expect(Cylinder{1, 0.1}, at(0), Cylinder{1, 0.1}, at(0.7, 0, 0.05), 0.05, {0, 0, 1});
    expect(Sphere{0.5}, at(0), Box{{1, 1, 1}}, at(1.4, 0.2, 0.1), 0.1, {1, 0, 0});
    expect(Capsule{0.25, 1}, at(0), Ellipsoid{{0.5, 0.4, 0.3}}, at(0.7), 0.05, {1, 0, 0});
    expect(Cone{0.5, 1}, at(0), Box{{2, 2, 0.5}}, at(0, 0, -0.9), 0.1, {0, 0, -1});
    expect(HalfSpace{}, at(0), Cylinder{0.5, 1}, at(0, 0, 0.3), 0.2, {0, 0, 1});
    const Penetration apart = between(Shape(Sphere{1}), at(0), Shape(Cone{1, 1}), at(9));
    EXPECT_EQ(apart.parting_lower, 0);
    EXPECT_EQ(apart.parting_upper, 0);
    EXPECT_EQ(between(cube, at(0), Shape(Sphere{1}), at(1)).parting_upper, std::numeric_limits<double>::infinity());
}

TEST(Penetration, HalfSpacesThatFaceEachOtherOverlapInALayer)
{
    const Isometry3d down(Eigen::Quaterniond(0, 1, 0, 0));
    const Penetration p = between(Shape(HalfSpace{}), at(0), Shape(HalfSpace{}), at(0, 0, -2) * down);
    EXPECT_EQ(p.depth, 2);
    EXPECT_EQ(p.depth_upper, 2);
    EXPECT_EQ(between(Shape(HalfSpace{}), at(0), Shape(HalfSpace{}), at(0, 0, -2)).depth,
              std::numeric_limits<double>::infinity());
}

TEST(Penetration, APairWithoutADepthSaysSoAlone)
{
    World world({.exact = ExactLevel::predicates});
    const auto body = [&](const GeometryData& data, const Isometry3d& pose) {
        return world.bodies().add(
            {.model = world.models().add(std::make_shared<const Geometry>(Geometry{"", data, ""})), .pose = pose});
    };
    const BodyId ground = body(flat_terrain(), at(0)), other = body(flat_terrain(), at(0, 0, -1)),
                 ball = body(Shape(Sphere{1}), at(0.1, 0.1, 0.5));
    const PairOfBodies pairs[] = {{ground, ball}, {ground, other}, {ball, other}};
    Penetration found[3];
    world.pairs().penetration(pairs, found);
    EXPECT_NEAR(found[0].depth, 0.5, 1e-9);
    EXPECT_NEAR(found[0].depth_upper, 0.5, 1e-9);
    EXPECT_FALSE(found[1].supported);
    EXPECT_TRUE(found[0].supported && found[2].supported);
    EXPECT_EQ(found[2].depth, 0);
}

} // namespace
} // namespace oncollide::penetration_test
