// Pairs of shapes, compared with bounds on their distance that share no code with the library.
#include <gtest/gtest.h>

#include <random>

#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/narrowphase/shapes/convex_pair.hpp>

#include "random_pose.hpp"
#include "truth/convex_truth.hpp"

namespace oncollide {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Drawn {
    std::unique_ptr<Model> model;
    Isometry3d pose;

    Drawn(Shape shape, const Isometry3d& at)
        : model(std::make_unique<Model>(std::make_shared<const Geometry>(Geometry{"shape", std::move(shape), {}}))),
          pose(at)
    {
    }
};

/// @param thinnest  the least length, as a share of the size
Shape draw_shape(std::mt19937_64& random, double size, double thinnest = 0.1)
{
    const auto length = [=](std::mt19937_64& from) {
        return size * std::pow(thinnest, std::uniform_real_distribution<double>()(from));
    };
    switch (random() % 7) {
    case 0:
        return Sphere{length(random)};
    case 1:
        return Box{{length(random), length(random), length(random)}};
    case 2:
        return Capsule{length(random), random() % 4 ? length(random) : 0};
    case 3:
        return Cylinder{length(random), length(random)};
    case 4:
        return Ellipsoid{{length(random), length(random), length(random)}};
    case 5:
        return Cone{length(random), length(random)};
    default: {
        ConvexHull hull;
        std::normal_distribution<double> normal;
        for (int k = 0; k < 12; ++k)
            hull.points.push_back(length(random) *
                                  Vector3d(normal(random), normal(random), normal(random)).normalized());
        return hull;
    }
    }
}

TEST(ConvexPair, AgreesWithExtendedPrecision)
{
    std::mt19937_64 random(1);
    int meet = 0, apart = 0;
    for (int k = 0; k < 20000; ++k) {
        const double size = std::pow(10.0, int(random() % 7) - 3);
        Drawn a(draw_shape(random, size), random_pose(random(), size)),
            b(draw_shape(random, size), random_pose(random(), size));
        const RelativePose b_to_a(a.pose, b.pose);
        const ConvexPair pair(a.model->convex(), b.model->convex(), b_to_a, 4e-15);
        const ConvexMeeting m = pair.meeting();
        const ConvexDistance d = pair.distance({.tolerance = 1e-9 * size});
        const auto truth = tools::true_distance(tools::convex_sets(a.model->geometry().data, a.pose),
                                                tools::convex_sets(b.model->geometry().data, b.pose));
        const double tie = 1e-13 * size;
        ASSERT_NE(m.sign, 0);
        (m.sign < 0 ? meet : apart)++;
        if (m.sign < 0) {
            ASSERT_LT(truth.lower, tie) << k;
        } else {
            ASSERT_GT(truth.upper, m.bound - tie) << k;
            ASSERT_GT(truth.upper, 0) << k;
        }
        ASSERT_LE(d.lower, truth.upper + tie) << k;
        ASSERT_GE(d.upper, truth.lower - tie) << k;
        if (m.sign > 0) {
            EXPECT_LE(d.upper - d.lower, 1.1e-9 * size + 1e-6 * d.upper) << k << " " << d.upper << " " << truth.upper;
        }
    }
    EXPECT_GT(meet, 1000);
    EXPECT_GT(apart, 1000);
}

TEST(ConvexPair, FlatAndLongShapesThatAllButTouchAreNeverDecidedWrongly)
{
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> unit(-1, 1);
    int open = 0, meet = 0, apart = 0;
    for (int k = 0; k < 5000; ++k) {
        const double size = std::pow(10.0, int(random() % 7) - 3), thinnest = std::pow(10.0, -double(random() % 6));
        Drawn a(draw_shape(random, size, thinnest), random_pose(random(), size)),
            b(draw_shape(random, size, thinnest), random_pose(random(), size));
        const auto farthest = [](const Drawn& d, const Vector3d& u) -> Vector3d {
            const Convex& c = d.model->convex();
            return d.pose * c.support(d.pose.linear().transpose() * u) + c.radius * u;
        };
        const Vector3d u = Vector3d(unit(random), unit(random), unit(random)).normalized();
        const double gap = size * thinnest * std::pow(10.0, -7.5 * (1 + unit(random))) * (random() % 2 ? 1 : -1);
        b.pose.translation() += farthest(a, u) - farthest(b, -u) + gap * u;
        const auto truth = tools::true_distance(tools::convex_sets(a.model->geometry().data, a.pose),
                                                tools::convex_sets(b.model->geometry().data, b.pose));
        // A polytope is exactly its transformed vertices; for other shapes only extended precision has an error.
        const auto polytope = [](const Drawn& d) {
            return d.model->convex().flat_sided && d.model->convex().radius == 0;
        };
        const bool exact = polytope(a) && polytope(b);
        const double tie = (exact ? 1e-14 : 1e-17) * size;
        for (const bool swapped : {false, true}) {
            const Drawn &first = swapped ? b : a, &second = swapped ? a : b;
            const RelativePose into(first.pose, second.pose);
            const ConvexMeeting m = ConvexPair(first.model->convex(), second.model->convex(), into, 4e-15).meeting();
            (m.sign < 0 ? meet : m.sign > 0 ? apart : open)++;
            if (m.sign <= 0) {
                ASSERT_LE(truth.lower, m.bound + tie) << k;
            } else {
                ASSERT_GT(truth.upper + (exact ? tie : 0), 0) << k;
                ASSERT_GE(truth.upper, m.bound - tie) << k;
            }
        }
    }
    EXPECT_GT(meet, 3000);
    EXPECT_GT(apart, 3000);
    EXPECT_LT(open, 2500); // the gap is below rounding
}

TEST(ConvexPair, OneVerdictInBothOrdersAndAsSharpAtAnySize)
{
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto direction = [&] { return Vector3d(unit(random), unit(random), unit(random)).normalized(); };
    PairWorker worker;
    int open = 0, wide = 0;
    for (int k = 0; k < 12000; ++k) {
        const double size = std::pow(10.0, int(random() % 19) - 9), thinnest = std::pow(10.0, -double(random() % 6));
        Drawn a(draw_shape(random, size, thinnest), random_pose(random(), size)),
            b(draw_shape(random, size, thinnest), random_pose(random(), size));
        if (k % 4 == 0) b.pose.linear() = a.pose.linear();
        const auto farthest = [](const Drawn& d, const Vector3d& u) -> Vector3d {
            const Convex& c = d.model->convex();
            return d.pose * c.support(d.pose.linear().transpose() * u) + c.radius * u;
        };
        Vector3d u = direction();
        if (k % 3 == 0) u = a.pose.linear() * Vector3d(unit(random), unit(random), 0).normalized();
        const double gap = size * std::pow(10.0, -4 - 6 * (1 + unit(random))) * (random() % 2 ? 1 : -1);
        b.pose.translation() += farthest(a, u) - farthest(b, -u) + gap * u;
        if (random() % 2) { // the nearest points are not where the support points are
            const Vector3d along = size * thinnest * direction();
            b.pose.translation() += along - u * along.dot(u);
        }
        const PairTask task{0, a.model.get(), b.model.get(), &a.pose, &b.pose},
            back{0, b.model.get(), a.model.get(), &b.pose, &a.pose};
        const Finding found = tests_for(task).decide(worker, task, {}, nullptr);
        ASSERT_EQ(found, tests_for(back).decide(worker, back, {}, nullptr)) << k;
        if (found.verdict != Verdict::within) continue;
        const auto extent = [](const Drawn& d) { return d.model->convex().extent + d.model->convex().radius; };
        const double scale = extent(a) + extent(b) + (a.pose.translation() - b.pose.translation()).norm();
        const auto truth = tools::true_distance(tools::convex_sets(a.model->geometry().data, a.pose),
                                                tools::convex_sets(b.model->geometry().data, b.pose));
        ASSERT_LE(truth.lower, found.bound + 1e-17 * scale) << k;
        const double excess = (found.bound - static_cast<double>(truth.lower)) / scale;
        ++open;
        if (excess > 0x1p-44) ++wide;
        ASSERT_LE(excess, 0x1p-38) << k << " at the size " << size;
    }
    EXPECT_GT(open, 500);
    EXPECT_LT(wide, open / 50);
}

int sign_of(const Shape& a, const Shape& b, const Vector3d& at,
            const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity())
{
    Isometry3d pose(turn);
    pose.translation() = at;
    const Drawn first(a, Isometry3d::Identity()), second(b, pose);
    const RelativePose b_to_a(first.pose, pose), a_to_b(pose, first.pose);
    const ConvexMeeting m = ConvexPair(first.model->convex(), second.model->convex(), b_to_a, 0).meeting();
    EXPECT_EQ(m.sign > 0, m.bound > 0 && m.sign != 0);
    EXPECT_EQ(ConvexPair(second.model->convex(), first.model->convex(), a_to_b, 0).meeting().sign, m.sign);
    return m.sign;
}

Shape hull_of_box(const Vector3d& half)
{
    ConvexHull hull;
    for (int k = 0; k < 8; ++k)
        hull.points.push_back(half.cwiseProduct(Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)));
    return hull;
}

/// Tangent shapes, and shapes moved apart by one ulp.
void expect_tangent(const Shape& a, const Shape& b, const Vector3d& at, int axis)
{
    Vector3d beyond = at, nearer = at;
    beyond[axis] = std::nextafter(at[axis], at[axis] * 2), nearer[axis] = std::nextafter(at[axis], 0);
    EXPECT_EQ(sign_of(a, b, at), -1);
    EXPECT_EQ(sign_of(a, b, nearer), -1);
    EXPECT_EQ(sign_of(a, b, beyond), 1);
}

TEST(ConvexPair, BallsThatAreTangentMeetAndAnUlpFartherTheyAreApart)
{
    for (const double scale : {1.0, 0x1p-30, 0x1p30}) {
        const auto at = [&](double x, double y, double z) { return Vector3d(scale * x, scale * y, scale * z); };
        const Shape box = Box{at(1, 2, 3)}, hull = hull_of_box(at(1, 2, 3));
        const Shape point = Sphere{scale * 3}, five = Sphere{scale * 5}, capsule = Capsule{scale * 5, scale * 2};
        for (const Shape& solid : {box, hull}) {
            expect_tangent(solid, point, at(4, 0.5, -0.25), 0);          // face
            expect_tangent(solid, five, at(1 + 3, 2 + 4, 1), 0);         // edge
            expect_tangent(solid, point, at(1 + 1, 2 + 2, 3 + 2), 0);    // corner
            expect_tangent(solid, capsule, at(1 + 3, 2 + 4, 3), 1);      // along an edge
            expect_tangent(solid, capsule, at(-1 - 5, 0.5, 3.5), 0);     // along a face
            expect_tangent(solid, capsule, at(0.5, 0.25, 3 + 5 + 1), 2); // its end touches a face
        }
        expect_tangent(point, five, at(8, 0, 0), 0);
        expect_tangent(point, Sphere{scale * 10}, at(3, 4, 12), 2);
        expect_tangent(capsule, point, at(8, 0, 0.5), 0);
        expect_tangent(capsule, Sphere{scale * 2}, at(2, 3, 6 + 1), 1);
        expect_tangent(capsule, capsule, at(6, 8, 1), 0);
        const Eigen::Matrix3d turn{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}};
        EXPECT_EQ(sign_of(capsule, capsule, at(10, 0, 0), turn), -1);
        EXPECT_EQ(sign_of(capsule, capsule, {std::nextafter(scale * 10, scale * 11), 0, 0}, turn), 1);
    }
}

TEST(ConvexPair, BoxesAndHullsThatTouchMeetAndAnUlpFartherTheyAreApart)
{
    const Shape box = Box{{1, 2, 3}}, hull = hull_of_box({1, 2, 3}), small = Box{{0.25, 0.25, 0.25}};
    for (const Shape& a : {box, hull})
        for (const Shape& b : {box, hull}) {
            expect_tangent(a, b, {2, 0, 0}, 0);
            expect_tangent(a, b, {2, 4, 0}, 1);
            expect_tangent(a, b, {2, 4, 6}, 2);
            EXPECT_EQ(sign_of(a, b, {0, 0, 0}), -1);
        }
    EXPECT_EQ(sign_of(box, small, {0.75, 0, 0}), -1);
    EXPECT_EQ(sign_of(hull, small, {0.5, 0.25, -0.125}), -1);
}

/// The first two points of the search are the ends of an edge. The second one changes the direction by 3e-10, and the
/// distance by less than a rounding.
TEST(ConvexPair, ACapsuleBesideTheTipOfABoxsEdgeIsApart)
{
    const double across = std::hypot(0.1, 0.1), radius = across - 2e-11;
    const Convex capsule = convex_of(Shape(Capsule{radius, 0.5})), box = convex_of(Shape(Box{{0.25, 0.875, 1}}));
    for (const double beyond : {0x1p-34, 0x1p-36, -0x1p-35}) {
        const RelativePose b_to_a(Isometry3d(Eigen::Translation3d(0.35, 0.975, 1.25 - beyond)), Isometry3d::Identity());
        const ConvexPair pair(capsule, box, b_to_a, 1e-16); // as of rotated poses
        EXPECT_EQ(pair.meeting().sign, 1) << beyond;
        EXPECT_NEAR(pair.distance({}).lower, across - radius, 1e-13) << beyond;
    }
}

TEST(ConvexPair, CylindersAreDecidedButForRounding)
{
    const Shape cylinder = Cylinder{1, 2}, box = Box{{1, 1, 1}}, flat = Cylinder{0.5, 0.1};
    const Eigen::Matrix3d across{{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}};
    for (const double gap : {1e-6, 1e-9, 1e-12, 2e-13}) {
        for (const int side : {-1, 1}) {
            const double off = side * gap;
            EXPECT_EQ(sign_of(cylinder, box, {2 + off, 0.1, 0.3}), side) << gap;
            EXPECT_EQ(sign_of(cylinder, box, {0.1, 0.2, 2 + off}), side) << gap;
            EXPECT_EQ(sign_of(cylinder, cylinder, {2 + off, 0, 0.5}), side) << gap;
            EXPECT_EQ(sign_of(cylinder, cylinder, {1.2 + 1.2 * off, 1.6 + 1.6 * off, 0.5}), side) << gap;
            EXPECT_EQ(sign_of(cylinder, cylinder, {2 + off, 0, 0.5}, across), side) << gap;
            EXPECT_EQ(sign_of(cylinder, flat, {1.05 + off, 0.1, 0.2}, across), side) << gap;
            EXPECT_EQ(sign_of(cylinder, Sphere{0.5}, {0.3, 0.2, 1.5 + off}), side) << gap;
            EXPECT_EQ(sign_of(cylinder, Sphere{0.5}, {0.9 + off, 1.2 + off, 0.5}), side) << gap;
            EXPECT_EQ(sign_of(cylinder, Sphere{5}, {1 + 3 + off, 0, 1 + 4 + off}), side) << gap;
        }
    }
    EXPECT_EQ(sign_of(cylinder, box, {2, 0.1, 0.3}), 0);
    EXPECT_EQ(sign_of(cylinder, cylinder, {0, 0, 0}), -1);
}

} // namespace
} // namespace oncollide
