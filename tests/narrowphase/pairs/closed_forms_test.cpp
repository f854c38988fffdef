// Decisions in closed form, compared with the general tests of shapes and with arithmetic in long double.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/pairs/closed_forms.hpp>
#include <oncollide/narrowphase/pairs/half_space.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/shapes/convex_pair.hpp>
#include <oncollide/narrowphase/shapes/exact_cores.hpp>

#include "random_pose.hpp"

namespace oncollide::closed_forms_test {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;
using Wide = Eigen::Matrix<long double, 3, 1>;

double number(std::uint64_t seed, std::uint64_t k)
{
    return double(splitmix(splitmix(seed) + k) >> 11) * 0x1p-53;
}

Model model_of(const Shape& shape)
{
    return Model(std::make_shared<const Geometry>(Geometry{"shape", shape, {}}));
}

std::vector<Shape> partners(std::uint64_t seed)
{
    const auto size = [&](int k) { return 0.1 + number(seed, 40 + k); };
    ConvexHull hull;
    for (int k = 0; k < 12; ++k) hull.points.push_back(random_pose(seed + k, size(3)).translation());
    return {Sphere{size(0)},
            Box{{size(0), size(1), size(2)}},
            Capsule{size(0), size(1)},
            Cylinder{size(0), size(1)},
            Cone{size(0), size(1)},
            Ellipsoid{{size(0), size(1), size(2)}},
            hull};
}

/// The same rotation, up to 2^-21 from rigid.
void bend(Isometry3d& pose, std::uint64_t seed)
{
    for (int i = 0; i < 9; ++i) pose.linear()(i / 3, i % 3) += 2e-7 * (number(seed, 60 + i) - 0.5);
}

/// The distance of a point from a shape without its radius, in long double.
long double distance_from(const Shape& shape, const Wide& p)
{
    const auto beyond = [](long double x, long double half) { return std::max(std::abs(x) - half, 0.0L); };
    const long double across = std::hypot(p.x(), p.y());
    if (std::holds_alternative<Sphere>(shape)) return p.norm();
    if (const auto* box = std::get_if<Box>(&shape))
        return Wide(beyond(p.x(), box->half.x()), beyond(p.y(), box->half.y()), beyond(p.z(), box->half.z())).norm();
    if (const auto* capsule = std::get_if<Capsule>(&shape))
        return Wide(p.x(), p.y(), beyond(p.z(), 0.5L * capsule->length)).norm();
    if (const auto* cylinder = std::get_if<Cylinder>(&shape))
        return std::hypot(beyond(across, cylinder->radius), beyond(p.z(), 0.5L * cylinder->length));
    const Cone& cone = std::get<Cone>(shape); // its profile is a triangle: the least distance from its three edges
    const long double half = 0.5L * cone.length, r = cone.radius;
    if (p.z() >= -half && across <= r * (half - p.z()) / cone.length) return 0;
    const auto from_edge = [&](long double x0, long double z0, long double x1, long double z1) {
        const long double dx = x1 - x0, dz = z1 - z0;
        const long double t = std::clamp(((across - x0) * dx + (p.z() - z0) * dz) / (dx * dx + dz * dz), 0.0L, 1.0L);
        return std::hypot(across - x0 - t * dx, p.z() - z0 - t * dz);
    };
    return std::min(from_edge(0, -half, r, -half), from_edge(r, -half, 0, half));
}

struct Counts {
    int colliding = 0, separate = 0, open = 0;

    void take(const std::optional<Finding>& found)
    {
        ++(!found ? open : found->verdict == Verdict::colliding ? colliding : separate);
    }
};

TEST(ClosedForms, DecideSpheresLikeLongDoubleAndTheGeneralTest)
{
    Counts counts;
    for (std::uint64_t seed = 0; seed < 3000; ++seed)
        for (const Shape& shape : partners(seed)) {
            SCOPED_TRACE(testing::Message() << shape.index() << " at " << seed);
            const double radius = 0.05 + number(seed, 1);
            Model ball = model_of(Sphere{radius}), other = model_of(shape);
            const double away = seed % 3 == 0 ? 1e6 : 1;
            Isometry3d pose = random_pose(seed, away), at = random_pose(seed + 1, away);
            // Near the surface: half of the seeds within 1e-12 to 1e-3.
            at.translation() = pose * Vector3d(2.5 * (random_pose(seed + 2, 1).translation()));
            if (seed % 2 && !std::holds_alternative<ConvexHull>(shape) && !std::holds_alternative<Ellipsoid>(shape)) {
                const Wide p =
                    (pose.linear().transpose() * (at.translation() - pose.translation())).cast<long double>();
                const long double apart = distance_from(shape, p) - radius - other.convex().radius;
                const Vector3d out = (at.translation() - pose.translation()).normalized();
                at.translation() -=
                    out * double(apart + std::pow(10, -3 - 9 * number(seed, 2)) * (seed % 4 == 1 ? 1 : -1));
            }
            if (seed % 5 == 0) bend(pose, seed), bend(at, seed + 1);
            const PairTask task{0, &ball, &other, &at, &pose}, back = task.swapped();
            const std::optional<Finding> found = decide_by_centre(task, 0), again = decide_by_centre(back, 0);
            ASSERT_EQ(found.has_value(), again.has_value());
            counts.take(found);
            if (std::holds_alternative<ConvexHull>(shape) || std::holds_alternative<Ellipsoid>(shape)) {
                EXPECT_FALSE(found);
                continue;
            }
            const PlacedPair placed(task);
            const ConvexPair general(ball.convex(), other.convex(), placed.b_to_a, placed.slack);
            const ConvexDistance d = general.distance({});
            const double size = (at.translation() - pose.translation()).norm() + ball.reach() + other.reach();
            const double doubt = 4 * placed.slack * size + 0x1p-45 * size;
            if (!found) {
                EXPECT_LE(d.lower, 2 * doubt) << "rounding hides nothing there";
                continue;
            }
            EXPECT_EQ(*found, *again);
            const Eigen::Matrix<long double, 3, 3> frame = pose.linear().cast<long double>();
            const Wide p =
                frame.inverse() * (at.translation().cast<long double>() - pose.translation().cast<long double>());
            const long double apart = distance_from(shape, p) - radius - other.convex().radius;
            if (found->verdict == Verdict::colliding) {
                EXPECT_LE(apart, 2 * placed.slack * size) << double(apart);
                EXPECT_EQ(d.lower, 0);
            } else {
                EXPECT_GT(found->bound, 0);
                EXPECT_LE(found->bound, apart + 2 * placed.slack * size) << double(apart);
                EXPECT_NEAR(found->bound, d.lower, 2 * doubt);
            }
        }
    EXPECT_GT(counts.colliding, 1500);
    EXPECT_GT(counts.separate, 2000);
}

TEST(ClosedForms, LeaveTouchesOpenAndDecideAllOthersByTheClearance)
{
    Model ball = model_of(Sphere{1}), box = model_of(Box{{1, 2, 3}});
    const Isometry3d here = Isometry3d::Identity();
    const Isometry3d touching(Eigen::Translation3d(2, 0, 0)), near(Eigen::Translation3d(2.5, 0, 0));
    EXPECT_FALSE(decide_by_centre({0, &box, &ball, &here, &touching}, 0));
    EXPECT_NEAR(decide_by_centre({0, &box, &ball, &here, &near}, 0)->bound, 0.5, 1e-12);
    EXPECT_EQ(decide_by_centre({0, &box, &ball, &here, &near}, 0.4)->verdict, Verdict::separate);
    EXPECT_FALSE(decide_by_centre({0, &box, &ball, &here, &near}, 0.5));
    EXPECT_FALSE(decide_by_centre({0, &box, &box, &here, &near}, 0));
}

TEST(ClosedForms, LeaveLengthsOpenWhoseSquaresUnderflow)
{
    Model ball = model_of(Sphere{1e-200}), box = model_of(Box{{1e-200, 1e-200, 1e-200}}), plane = model_of(HalfSpace{});
    Model grain = model_of(Ellipsoid{{1e-200, 1e-200, 1e-200}});
    const Isometry3d here = Isometry3d::Identity(), near(Eigen::Translation3d(1e-180, 0, 0));
    EXPECT_FALSE(decide_by_centre({0, &box, &ball, &here, &near}, 0));
    EXPECT_FALSE(decide_by_height({0, &plane, &grain, &here, &here}, false, 0));
}

TEST(ClosedForms, DecideHeightsLikeTheGeneralTest)
{
    Counts counts;
    for (std::uint64_t seed = 0; seed < 3000; ++seed)
        for (const Shape& shape : partners(seed)) {
            SCOPED_TRACE(testing::Message() << shape.index() << " at " << seed);
            Model plane = model_of(HalfSpace{}), body = model_of(shape);
            Isometry3d ground = random_pose(seed, seed % 3 == 0 ? 1e6 : 1), pose = random_pose(seed + 1, 1);
            if (seed % 7 == 0) pose.linear() = ground.linear();
            if (seed % 5 == 0) bend(ground, seed), bend(pose, seed + 1);
            const auto height = [&] {
                return HalfSpacePair<operand::Solid>(body, RelativePose(ground, pose), 0).distance(INFINITY);
            };
            // Near the ground: from 1e-16 to 1 m, above and below it.
            pose.translation() = ground * Vector3d(number(seed, 1), number(seed, 2), 3);
            const double gap = std::pow(10, -16 * number(seed, 3)) * (seed % 2 ? 1 : -1);
            pose.translation() -= (height().upper - gap) * ground.linear().col(2);
            for (const bool swapped : {false, true}) {
                const PairTask task =
                    swapped ? PairTask{0, &body, &plane, &pose, &ground} : PairTask{0, &plane, &body, &ground, &pose};
                const std::optional<Finding> found = decide_by_height(task, swapped, 0);
                counts.take(found);
                const PlacedPair placed(ground, pose);
                const ConvexMeeting m = HalfSpacePair<operand::Solid>(body, placed.b_to_a, placed.slack).meeting();
                if (!found) { // of round shapes, rounding may hide a little more than in the general test
                    EXPECT_TRUE(m.sign == 0 || !body.convex().flat_sided);
                    EXPECT_LE(std::abs(gap), 1e-13 * (1 + ground.translation().norm()) + 4 * placed.slack);
                } else if (m.sign == 0) {
                    EXPECT_LE(found->bound, 2 * m.bound);
                } else {
                    EXPECT_EQ(found->verdict, m.sign < 0 ? Verdict::colliding : Verdict::separate);
                    if (m.sign > 0) {
                        EXPECT_NEAR(found->bound, placed.below(m.bound),
                                    1e-14 * (1 + ground.translation().norm() + m.bound) +
                                        4 * placed.slack * body.reach());
                    }
                }
            }
        }
    EXPECT_GT(counts.colliding, 5000);
    EXPECT_GT(counts.separate, 5000);
    EXPECT_GT(counts.open, 0);
}

TEST(ClosedForms, DecideBoxesLikeExactArithmetic)
{
    Counts counts;
    for (std::uint64_t seed = 0; seed < 20'000; ++seed) {
        SCOPED_TRACE(seed);
        const auto half = [&](int k) {
            return std::round(16 * (0.05 + number(seed, std::uint64_t(k)))) / 16 + 1.0 / 16;
        };
        Model a = model_of(Box{{half(0), half(1), half(2)}}), b = model_of(Box{{half(3), half(4), half(5)}});
        const double away = seed % 3 == 0 ? 1e5 : 1;
        Isometry3d pose_a = random_pose(seed, away), pose_b = random_pose(seed + 1, 1);
        if (seed % 4 == 1) pose_b.linear() = pose_a.linear();                   // parallel faces and edges
        if (seed % 4 == 2) pose_a.setIdentity(), pose_b.linear().setIdentity(); // touching exactly, in part
        if (seed % 4 == 3)
            pose_b.linear() = pose_a.linear() * Eigen::AngleAxisd(1e-7 * number(seed, 7), Vector3d::UnitY());
        const Vector3d way(std::round(32 * number(seed, 8)) / 16, std::round(32 * number(seed, 9)) / 16,
                           half(2) + half(5));
        pose_b.translation() = pose_a * (seed % 8 < 4 ? way : Vector3d(1.3 * way));
        if (seed % 8 == 4)
            pose_b.translation() = pose_a * Vector3d(2 * number(seed, 10), 2 * number(seed, 11), 1 + number(seed, 12));
        if (seed % 5 == 0) bend(pose_a, seed), bend(pose_b, seed + 1);
        const PairTask task{0, &a, &b, &pose_a, &pose_b};
        double depth = 0;
        const std::optional<Finding> found = decide_by_axes(task, 0, depth);
        counts.take(found);
        const PlacedPair placed(task);
        const double gap = exact_gap(a.convex(), b.convex(), placed.b_to_a);
        const ConvexPair general(a.convex(), b.convex(), placed.b_to_a, placed.slack);
        const double doubt = (0x1p-44 + 4 * placed.slack) * (a.reach() + b.reach() + placed.b_to_a.translation.norm());
        if (!found) {
            EXPECT_LE(general.distance({}).lower, 2 * doubt) << "rounding hides nothing there";
        } else if (found->verdict == Verdict::colliding) {
            EXPECT_LE(gap, 0);
            EXPECT_GT(depth, 0);
            EXPECT_LE(depth, std::max(general.depth(), 0.0) + doubt);
        } else {
            EXPECT_GT(gap, 0);
            EXPECT_GT(found->bound, 0);
            EXPECT_LE(found->bound, general.distance({}).upper);
        }
    }
    EXPECT_GT(counts.colliding, 1000);
    EXPECT_GT(counts.separate, 3000);
    EXPECT_GT(counts.open, 1000) << "boxes that touch";
}

} // namespace
} // namespace oncollide::closed_forms_test
