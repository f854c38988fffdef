#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "robots/small_robot.hpp"
#include <oncollide/robots/spheres/sphere_judge.hpp>
#include <oncollide/robots/spheres/sphere_maker.hpp>

namespace oncollide::sphere_judge_test {
namespace {

using Eigen::Vector3d;
using test::SmallRobot;

RobotLink link_of(Shape shape)
{
    return {"part", {{std::make_shared<const Geometry>(Geometry{"part", std::move(shape), {}})}}};
}

/// The largest distance of random points of the surface from the nearest sphere; the share that is outside all.
std::pair<double, double> sampled(const LinkSurface& surface, std::span<const CoverSphere> spheres)
{
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    double gap = 0, outside = 0, all = 0;
    for (const LinkSurface::Corners& t : surface.triangles())
        for (int i = 0; i < 200; ++i) {
            double u = unit(random), v = unit(random);
            if (u + v > 1) u = 1 - u, v = 1 - v;
            const Vector3d point = t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
            double least = 1e9;
            for (const CoverSphere& s : spheres) least = std::min(least, (point - s.centre).norm() - s.radius);
            gap = std::max(gap, least);
            all += area_of(t), outside += least > 0 ? area_of(t) : 0;
        }
    return {gap, outside / all};
}

TEST(LinkSurface, HasSignedDistances)
{
    const LinkSurface cube(link_of(Box{{1, 1, 1}}));
    EXPECT_TRUE(cube.closed());
    EXPECT_NEAR(cube.area(), 24, 1e-12);
    EXPECT_NEAR(cube.signed_distance({0, 0, 0}), -1, 1e-9);
    EXPECT_NEAR(cube.signed_distance({0.9, 0, 0}), -0.1, 1e-9);
    EXPECT_NEAR(cube.signed_distance({2, 0, 0}), 1, 1e-9);
    EXPECT_NEAR(cube.signed_distance({2, 2, 2}), std::sqrt(3), 1e-9);
    EXPECT_GE(cube.signed_distance({1, 0, 0}), 0);
}

TEST(SphereJudge, BoundsTheShareAndTheGapFromBothSides)
{
    // A sphere of radius r > 1 about the centre of a cube of half size 1 leaves a ring of each face uncovered.
    const LinkSurface cube(link_of(Box{{1, 1, 1}}));
    const std::vector<CoverSphere> spheres{{{0, 0, 0}, 1.2}};
    const CoverJudgement judged = judge_cover(cube, spheres, {.edge = 2e-3, .gap = 1e-6});
    const double covered = 6 * std::numbers::pi * (1.44 - 1); // six discs
    EXPECT_LE(judged.uncovered, 24 - covered);
    EXPECT_GE(judged.uncovered_most, 24 - covered);
    EXPECT_LT(judged.uncovered_most - judged.uncovered, 0.1);
    EXPECT_FALSE(judged.complete);
    EXPECT_LE(judged.gap, std::sqrt(3) - 1.2 + 1e-12);
    EXPECT_GE(judged.gap_most, std::sqrt(3) - 1.2 - 1e-12);
    EXPECT_NEAR(judged.gap, std::sqrt(3) - 1.2, 2e-6);
    EXPECT_NEAR(judged.worst.cwiseAbs().minCoeff(), 1, 1e-3);
    EXPECT_NEAR(judged.over_reach, 0.2, 1e-9);
}

TEST(SphereJudge, ACoverOfSeveralSpheresIsComplete)
{
    const LinkSurface cube(link_of(Box{{1, 1, 1}}));
    std::vector<CoverSphere> spheres;
    for (int i = 0; i < 8; ++i)
        spheres.push_back({{i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5}, std::sqrt(0.75) + 1e-6});
    const CoverJudgement judged = judge_cover(cube, spheres);
    EXPECT_TRUE(judged.complete);
    EXPECT_EQ(judged.uncovered_most, 0);
    EXPECT_EQ(judged.gap_most, 0);
    spheres.erase(spheres.begin() + 3); // the corner (1, 1, -1)
    const CoverJudgement without = judge_cover(cube, spheres);
    EXPECT_FALSE(without.complete);
    EXPECT_GT(without.uncovered, 1);
    EXPECT_LT((without.worst - Vector3d(1, 1, -1)).norm(), 1e-4);
}

TEST(SphereJudge, WithoutSpheresAllIsUncovered)
{
    const LinkSurface cube(link_of(Box{{1, 1, 1}}));
    EXPECT_EQ(judge_cover(cube, {}).uncovered, cube.area());
    EXPECT_FALSE(judge_cover(cube, {}).complete);
}

TEST(SphereMaker, CoversEverythingWithinTheError)
{
    const SmallRobot files;
    RobotDescription robot = load_robot(files.urdf, {.packages = {{"robot", files.folder().path()}}});
    for (RobotLink link : robot.links) {
        if (link.collision.empty()) continue;
        const LinkSurface surface(link);
        const SphereMaker maker(surface);
        std::size_t more = 0;
        for (const double error : {0.02, 0.01, 0.005}) {
            SCOPED_TRACE(link.name + " " + std::to_string(error));
            const std::vector<CoverSphere> spheres = maker.within(error);
            const CoverJudgement judged = judge_cover(surface, spheres);
            EXPECT_TRUE(judged.complete);
            EXPECT_LE(judged.over_reach, error);
            const auto [gap, outside] = sampled(surface, spheres);
            EXPECT_EQ(gap, 0);
            EXPECT_EQ(outside, 0);
            EXPECT_GE(spheres.size(), more);
            more = spheres.size();
        }
    }
}

TEST(SphereMaker, ACapsuleNeedsFewSpheres)
{
    // A rod of radius 0.1: spheres on its axis, 2 sqrt((0.1 + e)^2 - 0.1^2) apart, about 13 for e = 0.01.
    const LinkSurface rod(link_of(Capsule{0.1, 1.0}));
    const std::size_t count = SphereMaker(rod).within(0.01).size();
    EXPECT_GE(count, 12u);
    EXPECT_LE(count, 26u);
}

TEST(SphereMaker, OpenSurfacesAreCoveredFromTheirOwnPoints)
{
    Mesh sheet = make_mesh("sheet", {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}}, {{0, 1, 2}});
    const LinkSurface surface({"sheet", {{std::make_shared<const Geometry>(Geometry{"sheet", std::move(sheet), {}})}}});
    EXPECT_FALSE(surface.closed());
    const auto spheres = SphereMaker(surface).within(0.01);
    const CoverJudgement judged = judge_cover(surface, spheres);
    EXPECT_TRUE(judged.complete);
    EXPECT_LE(judged.over_reach, 0.01);
    EXPECT_LT(spheres.size(), 150u);
}

} // namespace
} // namespace oncollide::sphere_judge_test
