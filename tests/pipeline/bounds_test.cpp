// Bounds on distances, compared with rational arithmetic for triangles at which doubles fail.
#include <gtest/gtest.h>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "verify/oracle/exact_distance.hpp"
#include "verify/trials/hard_trials.hpp"

namespace oncollide::bounds_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

class EveryNearFamily : public testing::TestWithParam<NearFamily> {};

TEST_P(EveryNearFamily, HasBoundsThatRationalArithmeticConfirms)
{
    const tools::Tally tally = tools::try_bounds(GetParam(), 4'000, 2);
    EXPECT_EQ(tally.faults(), 0u) << tally.first_fault;
    EXPECT_GT(tally.bounds, 10 * tally.cases);
}

std::string name_of_family(const testing::TestParamInfo<NearFamily>& family)
{
    std::string name = family.param.name;
    std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
    return name;
}
INSTANTIATE_TEST_SUITE_P(Bounds, EveryNearFamily, testing::ValuesIn(near_families()), name_of_family);

TEST(Approach, OfBodiesOfAllKindsLosesNoCollisionInALiveWorld)
{
    const tools::Tally tally = tools::try_approaches(20'000, 2);
    EXPECT_EQ(tally.faults(), 0u) << tally.first_fault;
    EXPECT_GT(tally.cases, 15000u);
}

/// A corner above the middle of a triangle whose thickness is 2^-thin of its length.
TwoTriangles peak_above_sliver(int thin, double height)
{
    const double thick = std::ldexp(1.0, -thin);
    const Vector3d along(1, 0.75, -0.5), across(-0.75, 1, 0), up(0.5, 0.375, 1.5625); // orthogonal
    const Vector3d p = 0.25 * along + 0.25 * thick * across + height * up;
    return {{p, p + up + 0.25 * across, p + up - 0.25 * along}, {-along, along, 0.375 * along + thick * across}};
}

TEST(RememberedGap, OfASliverLosesNoCollision)
{
    int pierced = 0;
    for (int thin = 10; thin <= 40; ++thin)
        for (int low = 2; low <= 20; low += 3) {
            const auto [a, b] = peak_above_sliver(thin, std::ldexp(1.0, -thin - low));
            World live;
            const auto add = [&](const TrianglePoints& t) {
                return live.bodies().add(
                    {.model = live.models().add(make_mesh("triangle", {t[0], t[1], t[2]}, {{0, 1, 2}}))});
            };
            const BodyId peak = add(a), sliver = add(b);
            live.step(), live.step();
            const double bound = live.pairs().decide(peak, sliver).bound,
                         distance = oracle::ExactDistance(a, b).value();
            EXPECT_LE(bound, distance * (1 + 1e-12)) << thin << ' ' << low;
            for (const double share : {1.01, 1.5, 3.0}) {
                Isometry3d pose = Isometry3d::Identity();
                pose.translation() = -share * distance * Vector3d(0.5, 0.375, 1.5625).normalized();
                live.bodies().set_pose(peak, pose);
                const Verdict decided = live.pairs().decide(peak, sliver).verdict,
                              stepped = live.step().pairs[0].verdict;
                EXPECT_EQ(stepped, decided) << thin << ' ' << low << ' ' << share;
                pierced += decided == Verdict::colliding;
            }
        }
    EXPECT_GT(pierced, 200);
}

/// Two roofs whose ridges cross at 2^-`angle` rad, `height` apart: exact in doubles.
struct Roofs {
    World world;
    BodyId low, high;
    Roofs(int angle, double height)
    {
        const double tan = std::ldexp(1.0, -angle);
        low =
            world.bodies().add({.model = world.models().add(make_mesh(
                                    "low", {{-1, 0, 0}, {1, 0, 0}, {0, -1, -1}, {0, 1, -1}}, {{0, 2, 1}, {0, 1, 3}}))});
        high = world.bodies().add(
            {.model = world.models().add(make_mesh(
                 "high", {{-1, -tan, height}, {1, tan, height}, {0, -1, 1}, {0, 1, 1}}, {{0, 1, 2}, {0, 3, 1}}))});
    }
};

TEST(NearFeatures, ListEdgesThatCrossAtAnyAngle)
{
    for (int angle = 5; angle <= 50; ++angle)
        for (const double height : {0.0, 0x1p-40, 0x1p-30}) {
            Roofs roofs(angle, height);
            Lists<NearFeatures> lists;
            const PairOfBodies pair{roofs.low, roofs.high};
            roofs.world.pairs().near_features(std::span(&pair, 1), height + std::ldexp(1.0, -angle - 3), lists);
            bool listed = false;
            for (const NearFeatures& f : lists.items) {
                EXPECT_GE(f.upper, height) << angle;
                listed |= f.lower <= height;
            }
            EXPECT_TRUE(listed) << "angle 2^-" << angle << ", height " << height;
            if (height > 0) {
                EXPECT_FALSE(
                    roofs.world.pairs().manifold(roofs.low, roofs.high, {.margin = 2 * height}).regions.empty())
                    << angle;
            }
        }
}

/// An exact verdict and the distance agree.
TEST(KissingBoxes, InACommonRotationAreNoDistanceApartIfTheyCollide)
{
    int colliding = 0;
    CaseNumbers draw(5);
    for (int turn = 0; turn < 3000; ++turn) {
        const Vector3d a(draw.real(0.1, 1), draw.real(0.1, 1), draw.real(0.1, 1)),
            b(draw.real(0.1, 1), draw.real(0.1, 1), draw.real(0.1, 1));
        World world;
        Isometry3d pose_a = Isometry3d::Identity(), pose_b = pose_a;
        pose_a.linear() = pose_b.linear() = draw.rotation();
        pose_a.translation() = draw.vector();
        const int axis = turn % 3;
        Vector3d shift = 0.3 * draw.vector().cwiseProduct(a);
        shift[axis] = a[axis] + b[axis];
        pose_b.translation() = pose_a * shift;
        const BodyId first = world.bodies().add({.model = world.models().add(Box{a}), .pose = pose_a});
        const Shape other = turn % 4 ? Shape(Box{b}) : Shape(Sphere{.radius = b[axis]});
        const BodyId second = world.bodies().add({.model = world.models().add(other), .pose = pose_b});
        const Finding found = world.pairs().decide(first, second);
        const Distance distance = world.pairs().distance(first, second);
        if (found.verdict == Verdict::colliding) {
            ++colliding;
            EXPECT_EQ(distance.upper, 0) << turn;
        } else if (found.verdict == Verdict::separate) {
            EXPECT_GT(distance.upper, 0) << turn;
        }
        EXPECT_LE(distance.lower, distance.upper);
    }
    EXPECT_GT(colliding, 300);
}

} // namespace
} // namespace oncollide::bounds_test
