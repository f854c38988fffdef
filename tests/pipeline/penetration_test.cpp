// Penetration depths, compared with bodies whose depth is known.
#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/geometry.hpp>

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
        const ModelId model = world.add(std::make_shared<const Geometry>(Geometry{"", data, ""}));
        return world.add_body({.model = model, .pose = pose});
    };
    const BodyId first = add(a, pose_a);
    const PairOfBodies pair{first, add(b, pose_b)};
    Penetration found;
    world.penetration({&pair, 1}, {&found, 1});
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

TEST(Penetration, RefusesWhatHasNoTriangles)
{
    try {
        between(Shape(Sphere{1}), at(0), cube, at(0));
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::usage);
        EXPECT_NE(std::string(error.what()).find("not a mesh, box or hull"), std::string::npos) << error.what();
    }
}

} // namespace
} // namespace oncollide::penetration_test
