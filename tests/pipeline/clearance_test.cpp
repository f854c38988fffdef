// Clearances that are as small as rounding errors.
#include <cmath>

#include <gtest/gtest.h>

#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/generators.hpp>

#include "truth/truth.hpp"
#include "verify/cases/body_case.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

PairResult answer(const Mesh& a, const Isometry3d& pose_a, const Mesh& b, const Isometry3d& pose_b,
                  const Settings& settings)
{
    Scene scene;
    scene.add_body({.name = "a", .geometry = scene.add("a", a), .pose = pose_a});
    scene.add_body({.name = "b", .geometry = scene.add("b", b), .pose = pose_b});
    Pipeline pipeline(scene, settings);
    const FrameView frame = pipeline.step(scene);
    return frame.pairs.empty() ? PairResult{{Verdict::separate, ContactKind::unknown, 0}, StageId::bounds, {}, {}}
                               : frame.pairs[0];
}

/// Files whose vertices are far from their origins: after the pose, their rounding errors exceed the clearance.
TEST(Clearance, IsNotLostInWhatFilesFarAwayRound)
{
    const Mesh spike = mesh_of({{0, 0, 0}, {1, 0x1p-6, 0}, {1, -0x1p-6, 0x1p-6}}, {{0, 1, 2}});
    const Vector3d far(1e6, -1e6, 5e5);
    const Eigen::Matrix3d size = 1e-5 * Eigen::Matrix3d::Identity();
    const Mesh a = rotated(spike, size, far), b = rotated(spike, -size, far);
    int near = 0;
    for (int k = 0; k < 60; ++k) {
        const Isometry3d back =
            at(turn_by(0.9 + 0.1 * k, {1, 2, 3.0 - k}) * -far, turn_by(0.9 + 0.1 * k, {1, 2, 3.0 - k}));
        const Isometry3d other = at(-far, Eigen::Matrix3d::Identity());
        for (const double clearance : {1e-14, 1e-12, 1e-10, 1e-8}) {
            if (truth_of(a, back, b, other).distance.high > clearance) continue;
            ++near;
            for (const ExactLevel exact : {ExactLevel::off, ExactLevel::predicates}) {
                const PairResult result =
                    answer(a, back, b, other,
                           {.clearance = clearance, .exact = exact, .bounding_volume = BoundingVolume::obb});
                EXPECT_NE(result.verdict, Verdict::separate) << k << ", " << clearance;
                EXPECT_TRUE(std::isfinite(result.bound)) << k << ", " << clearance;
            }
        }
    }
    EXPECT_GT(near, 30);
}

TEST(Clearance, BoundsWhatIsNearerThanSquaresCanTell)
{
    const Mesh point = mesh_of({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}});
    for (const double distance : {0x1p-1060, 0x1p-700, 0x1p-300}) {
        const PairResult result = answer(point, at(0, 0, 0), point, at(0, distance, 0),
                                         {.clearance = distance, .exact = ExactLevel::predicates});
        EXPECT_EQ(result.kind, ContactKind::near) << distance;
        EXPECT_LE(result.bound, distance * (1 + 0x1p-16) + 1e-140);
    }
}

TEST(Clearance, IsMeasuredByFclAsWellFarFromTheOrigin)
{
    const Mesh ball = make_sphere_mesh(0.5, 128), box = make_box_mesh({1, 1, 1});
    const Vector3d far(1e8, -1e8, 5e7), aside(1.75, 0.25, 0.125);
    const Eigen::Matrix3d turn = turn_by(1, {3, 1, 2});
    const Settings settings{.clearance = 0.5, .exact = ExactLevel::fcl};
    const double here = answer(box, at({0, 0, 0}, turn), ball, at(aside, turn), settings).bound;
    const double there = answer(box, at(far, turn), ball, at(far + aside, turn), settings).bound;
    EXPECT_GT(here, 0.05);
    EXPECT_NEAR(there, here, 1e-12);
}

} // namespace
} // namespace oncollide::tools
