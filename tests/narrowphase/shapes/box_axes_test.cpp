// The overlaps of two boxes along their separating axes; the depth, distance and points that follow from them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/box_points.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/contact_points.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/shapes/box_axes_kernel.hpp>
#include <oncollide/narrowphase/shapes/convex_pair.hpp>

#include "random_pose.hpp"

namespace oncollide::box_axes_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

struct TwoAtPoses {
    Vector3d ha, hb;
    Isometry3d pose_a, pose_b;
    RelativePose b_to_a{pose_a, pose_b};
};

/// Boxes that overlap or are near each other; some are flat, some are almost aligned, some are large.
TwoAtPoses draw(std::mt19937_64& random)
{
    const auto number = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    const double scale = std::pow(10, number(-6, 6)), ratio = std::pow(10, number(-2, 2));
    const auto half = [&](double size) {
        Vector3d h = size * Vector3d(number(0.1, 1), number(0.1, 1), number(0.1, 1));
        if (number(0, 1) < 0.1) h[int(number(0, 2.99))] *= 1e-6;
        return h;
    };
    const auto direction = [&] { return Vector3d(number(-1, 1), number(-1, 1), number(-1, 1)).normalized(); };
    const Vector3d ha = half(scale), hb = half(scale * ratio);
    Isometry3d a(Eigen::AngleAxisd(number(-3, 3), direction())), b = a;
    if (number(0, 1) < 0.7) b.rotate(Eigen::AngleAxisd(std::pow(10, number(-12, 0.4)), direction()));
    a.translation() = scale * direction(), b.translation() = a.translation();
    b.translation() += number(0, 1.2) * (ha.norm() + hb.norm()) * direction();
    return {ha, hb, a, b};
}

Convex box_of(const Vector3d& half)
{
    return convex_of(Shape(Box{half}));
}

TEST(BoxAxes, KernelsGiveTheSameBits)
{
    if (instruction_set() < InstructionSet::avx2) GTEST_SKIP() << "no second instruction set";
    std::mt19937_64 random(1);
    for (int k = 0; k < 20'000; ++k) {
        const TwoAtPoses p = draw(random);
        const TwoBoxes boxes{p.ha.data(), p.hb.data(), p.b_to_a.rotation.data(), p.b_to_a.translation.data()};
        BoxOverlaps plain, wide;
        std::memset(&plain, 0, sizeof plain), std::memset(&wide, 0, sizeof wide);
        baseline::overlap_boxes()(boxes, 1e-15, plain), avx2::overlap_boxes()(boxes, 1e-15, wide);
        ASSERT_EQ(std::memcmp(&plain, &wide, sizeof plain), 0) << k;
    }
}

/// The exact overlap of two boxes along an axis, to about 2^-60 of their sizes.
long double overlap_along(const TwoAtPoses& p, const Eigen::Matrix<long double, 3, 1>& n)
{
    const auto r = p.b_to_a.rotation.cast<long double>();
    const auto t = p.b_to_a.translation.cast<long double>();
    return n.cwiseAbs().dot(p.ha.cast<long double>()) + (r.transpose() * n).cwiseAbs().dot(p.hb.cast<long double>()) -
           std::abs(n.dot(t));
}

TEST(BoxAxes, EdgesThatAreLeftOutOverlapMoreThanAFace)
{
    std::mt19937_64 random(2);
    int left_out = 0, open = 0;
    for (int k = 0; k < 20'000; ++k) {
        const TwoAtPoses p = draw(random);
        const TwoBoxes boxes{p.ha.data(), p.hb.data(), p.b_to_a.rotation.data(), p.b_to_a.translation.data()};
        const double rounding = 0x1p-47 * (p.ha.norm() + p.hb.norm() + p.b_to_a.translation.norm());
        BoxOverlaps found;
        baseline::overlap_boxes()(boxes, rounding, found);
        double least = INFINITY;
        for (int i = 0; i < 3; ++i) least = std::min({least, found.of_a[i], found.of_b[i]});
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 3; ++i) {
                Eigen::Matrix<long double, 3, 1> e = Eigen::Matrix<long double, 3, 1>::Unit(i),
                                                 n = e.cross(p.b_to_a.rotation.col(j).cast<long double>());
                const long double length = n.norm();
                ++(found.open >> (4 * j + i) & 1 ? open : left_out);
                if (found.open >> (4 * j + i) & 1 || length == 0) continue;
                ASSERT_GE(overlap_along(p, n), length * std::max(least - rounding, 0.0)) << k << ' ' << i << ' ' << j;
            }
    }
    EXPECT_GT(left_out, 10'000);
    EXPECT_GT(open, 10'000);
}

TEST(BoxAxes, DistanceIsThatOfTheNearestPoints)
{
    std::mt19937_64 random(3);
    int apart = 0, by_axis = 0;
    for (int k = 0; k < 20'000; ++k) {
        const TwoAtPoses p = draw(random);
        const Convex a = box_of(p.ha), b = box_of(p.hb);
        const PlacedPair placed(p.pose_a, p.pose_b);
        const ConvexPair pair(a, b, placed.b_to_a, placed.slack);
        const ConvexMeeting meeting = pair.meeting();
        const ConvexDistance found = pair.distance({}),
                             sure = convex_distance(ConvexDifference(a, b, placed.b_to_a, placed.slack), {});
        const double size = p.ha.norm() + p.hb.norm(), near = 1e-12 * size;
        ASSERT_EQ(meeting.sign > 0, found.upper > 0) << k;
        ASSERT_LE(found.lower, sure.upper) << k;
        ASSERT_GE(found.upper, sure.lower) << k;
        if (meeting.sign < 0) {
            ASSERT_LE(sure.upper, near) << k;
            ASSERT_LE(pair.depth(), 2 * size) << k;
            continue;
        }
        ++apart, by_axis += found.upper - meeting.bound < near;
        ASSERT_EQ(pair.depth(), 0) << k;
        ASSERT_LE(meeting.bound, sure.upper) << k;
        ASSERT_NEAR((found.on_b - found.on_a).norm(), found.upper, near) << k;
        ASSERT_LE((found.on_a.cwiseAbs() - p.ha).maxCoeff(), near) << k;
        const Vector3d on_b = placed.b_to_a.rotation.transpose() * (found.on_b - placed.b_to_a.translation);
        ASSERT_LE((on_b.cwiseAbs() - p.hb).maxCoeff(), near) << k;
    }
    EXPECT_GT(apart, 1000);
    EXPECT_GT(by_axis, 100);
    EXPECT_LT(by_axis, apart);
}

TEST(BoxAxes, PointsAreThoseOfAnyTwoFaces)
{
    std::mt19937_64 random(4);
    int pairs = 0, of_many = 0, matches = 0, of_one_feature = 0;
    for (int k = 0; k < 20'000; ++k) {
        const TwoAtPoses p = draw(random);
        const auto model = [](const Vector3d& half) {
            return Model(std::make_shared<const Geometry>(Geometry{"box", Shape(Box{half}), {}}));
        };
        Model a = model(p.ha), b = model(p.hb);
        const PlacedPair placed(p.pose_a, p.pose_b);
        const LeastTranslation least =
            least_translation(ConvexDifference(a.convex(), b.convex(), placed.b_to_a, placed.slack), 1e9, false);
        const double size = std::max(p.ha.norm(), p.hb.norm()), off = 1e-13 * (size + placed.b_to_a.translation.norm());
        FewPoints found;
        if (!find_box_points(a.convex(), b.convex(), placed.b_to_a, least.normal, ContactPoints::facing, off, found))
            continue;
        const Vector3d normal_b = placed.b_to_a.rotation.transpose() * least.normal;
        const double over_a = least.normal.cwiseAbs().maxCoeff(), over_b = normal_b.cwiseAbs().maxCoeff();
        ContactFace face_a, face_b;
        find_face(a, least.normal, face_a), find_face(b, -normal_b, face_b), face_b.place(placed.b_to_a);
        ContactPoints all;
        all.normal = least.normal;
        if (over_a + 0x1p-20 >= over_b)
            all.add_over(face_a, face_b, b.convex(), true, off);
        else
            all.add_over(face_b, face_a, a.convex(), false, off);
        ++pairs;
        // Points in places of doubt, on a face's rim, may be missing on either side.
        const double near = 1e-6 * size;
        double deepest = -INFINITY;
        for (const auto& c : all.points.chosen()) {
            bool same = false;
            for (const auto& d : found.chosen()) {
                if (!((d.on_a - c.on_a).norm() < near) || !((d.on_b - c.on_b).norm() < near)) continue;
                same = true;
                ++matches, of_one_feature += d.of_a == c.of_a && d.of_b == c.of_b;
            }
            ASSERT_TRUE(same) << k;
            deepest = std::max(deepest, c.depth);
        }
        if (found.empty()) continue;
        ASSERT_NEAR(found.deepest(), deepest, near) << k;
        of_many += found.count() > 4;
        for (const auto& d : found.chosen()) {
            ASSERT_NEAR(d.depth, least.normal.dot(d.on_a - d.on_b), 1e-3 * near) << k;
            ASSERT_LE((d.on_a.cwiseAbs() - p.ha).maxCoeff(), near) << k;
            const Vector3d on_b = placed.b_to_a.rotation.transpose() * (d.on_b - placed.b_to_a.translation);
            ASSERT_LE((on_b.cwiseAbs() - p.hb).maxCoeff(), near) << k;
        }
    }
    EXPECT_GT(of_one_feature, 0.9 * matches);
    EXPECT_GT(pairs, 5000);
    EXPECT_GT(of_many, 100);
}

} // namespace
} // namespace oncollide::box_axes_test
