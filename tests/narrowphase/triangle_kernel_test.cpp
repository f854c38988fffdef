// Eight pairs of triangles at a time against the exact test of one.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <oncollide/base/cpu_features.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/exact/triangle_kernel.hpp>
#include <oncollide/narrowphase/relative_pose.hpp>

#include "hard/triangle_families.hpp"

namespace oncollide {
namespace {

struct Kernel {
    std::string name;
    JudgePairs* judge;
    MeasurePairs* measure;
};

std::vector<Kernel> kernels()
{
    std::vector<Kernel> all{{"baseline", baseline::judge_pairs(), baseline::measure_pairs()}};
    if (instruction_set() >= InstructionSet::avx2) all.push_back({"avx2", avx2::judge_pairs(), avx2::measure_pairs()});
    if (instruction_set() >= InstructionSet::avx512)
        all.push_back({"avx512", avx512::judge_pairs(), avx512::measure_pairs()});
    return all;
}

CornersOfPairs corners_of(const std::vector<TwoTriangles>& eight)
{
    CornersOfPairs corners;
    for (unsigned i = 0; i < 8; ++i)
        for (unsigned k = 0; k < 3; ++k)
            corners.a[k][i] = eight[i].first[k].data(), corners.b[k][i] = eight[i].second[k].data();
    return corners;
}

double extent_of(const TwoTriangles& pair)
{
    double extent = 0;
    for (const Eigen::Vector3d& p : pair.first)
        for (const Eigen::Vector3d& q : pair.second) extent = std::max(extent, (p - q).norm());
    return extent;
}

/// Rotations, scales, and axes so different that some products of coordinates underflow or overflow and others do not.
std::vector<Eigen::Matrix3d> maps()
{
    std::vector<Eigen::Matrix3d> all;
    for (const double scale : {1.0, 1e-9, 1e9, 0x1p-900, 0x1p-1060, 0x1p500, 0x1p970}) {
        all.push_back(scale * Eigen::Matrix3d::Identity());
        all.push_back(scale * GridPoints(12).rotation());
    }
    for (const auto& [one, two] : {std::pair(290, -550), std::pair(-340, 600)})
        for (int axis = 0; axis < 3; ++axis) {
            Eigen::Vector3d scale = Eigen::Vector3d::Constant(std::ldexp(1, two));
            scale[axis] = std::ldexp(1, one);
            all.emplace_back(scale.asDiagonal());
        }
    return all;
}

/// Is it of a scale that the filter is made for?
bool ordinary(const Eigen::Matrix3d& map)
{
    return map.norm() < 1e20 && map.norm() > 1e-20;
}

class EveryFamilyInEights : public testing::TestWithParam<TriangleFamily> {};

TEST_P(EveryFamilyInEights, IsJudgedAsTheExactTestDoesOrLeftOpen)
{
    for (const Eigen::Matrix3d& map : maps()) {
        GridPoints random(11);
        std::size_t open = 0, pairs = 0, meeting = 0;
        for (unsigned turn = 0; turn < 70; ++turn) {
            constexpr unsigned count = 8;
            std::vector<TwoTriangles> eight;
            std::vector<bool> truth;
            for (unsigned i = 0; i < count; ++i) {
                eight.push_back(moved(GetParam().make(random), map, Eigen::Vector3d::Zero()));
                truth.push_back(triangles_meet(eight[i].first, eight[i].second));
                meeting += truth.back();
            }
            const CornersOfPairs corners = corners_of(eight);
            pairs += count;
            const RelativePose stay(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity());
            for (const Kernel& kernel : kernels()) {
                double nearest2[8];
                std::fill(std::begin(nearest2), std::end(nearest2), std::numeric_limits<double>::infinity());
                const PairVerdicts verdicts =
                    kernel.judge(corners, stay.rotation.data(), stay.translation.data(), nearest2);
                for (unsigned i = 0; i < count; ++i) {
                    const bool separate = verdicts.separate >> i & 1, known = verdicts.known >> i & 1;
                    EXPECT_TRUE(known || !separate) << kernel.name;
                    EXPECT_EQ(std::isfinite(nearest2[i]), separate) << kernel.name;
                    if (separate && ordinary(map)) {
                        const auto& [p, q] = eight[i];
                        const double rounding = 0x1p-38 * extent_of(eight[i]) + 0x1p-48 * p[0].norm();
                        EXPECT_GT(nearest2[i], 0) << kernel.name;
                        EXPECT_LE(std::sqrt(nearest2[i]), triangle_distance(p, q) + rounding) << kernel.name;
                    }
                    if (known) {
                        EXPECT_EQ(separate, !truth[i]) << kernel.name << " map\n" << map;
                    } else {
                        ++open;
                    }
                }
            }
        }
        if (GetParam().name == "random large" && ordinary(map)) {
            EXPECT_LE(open, kernels().size() * pairs / 100) << "a filter that knows";
            EXPECT_GT(meeting, 10u);
        }
    }
}

TEST_P(EveryFamilyInEights, HasNearestPointsThatASlabProvesAndTheSameBitsOnEveryInstructionSet)
{
    GridPoints random(13);
    const RelativePose turned(Eigen::Isometry3d(random.rotation()), Eigen::Isometry3d(random.rotation()));
    std::size_t proved = 0;
    for (unsigned turn = 0; turn < 200; ++turn) {
        std::vector<TwoTriangles> eight;
        for (unsigned i = 0; i < 8; ++i) eight.push_back(GetParam().make(random));
        const CornersOfPairs corners = corners_of(eight);
        const unsigned count = 1 + turn % 8;
        std::vector<NearestOfPairs> found;
        for (const Kernel& kernel : kernels()) {
            kernel.measure(corners, turned.rotation.data(), turned.translation.data(), count, found.emplace_back());
            for (unsigned i = 0; i < count; ++i) {
                const NearestPoints here = points_of(found.back(), i), first = points_of(found.front(), i);
                EXPECT_TRUE(here.a == first.a && here.b == first.b && here.distance == first.distance) << kernel.name;
            }
        }
        for (unsigned i = 0; i < count; ++i) {
            auto& [p, q] = eight[i];
            for (Eigen::Vector3d& corner : q) corner = turned(corner);
            if (triangles_meet(p, q)) continue;
            const NearestPoints points = points_of(found.front(), i);
            const double rounding = 0x1p-40 * extent_of(eight[i]);
            EXPECT_NEAR(points.distance, (points.b - points.a).norm(), rounding);
            EXPECT_EQ(points.distance, triangle_distance(p, q)) << "one pair alone";
            EXPECT_LE(points.distance, corner_distance(p, q) + rounding);
            if (points.distance < 1e-3 * extent_of(eight[i])) continue; // the line is known too roughly
            const Eigen::Vector3d line = (points.b - points.a) / points.distance;
            EXPECT_GE(least_along(line, q) - most_along(line, p), points.distance - 8 * rounding);
            EXPECT_NEAR(line.dot(points.a), most_along(line, p), 8 * rounding);
            EXPECT_NEAR(line.dot(points.b), least_along(line, q), 8 * rounding);
            ++proved;
        }
    }
    EXPECT_GT(proved, 200u);
}

TEST(TriangleKernel, MovesPointsToTheLastBitAsTheExactTestIsTold)
{
    // Triangles of B that end exactly on, or one step of a double above, a corner of A after the move.
    GridPoints random(21);
    const Eigen::Isometry3d a = Eigen::Isometry3d(random.rotation()), b = Eigen::Translation3d(0.3, 0.7, 0.1) * a;
    const RelativePose b_to_a(a, b);
    for (int turn = 0; turn < 200; ++turn) {
        TrianglePoints of_b{random.point(9), random.point(9), random.point(9)};
        TrianglePoints of_a{b_to_a(of_b[0]), b_to_a(of_b[0]), b_to_a(of_b[0])};
        of_a[1].z() += 1, of_a[2].x() += 1; // they share a corner
        const std::vector<TwoTriangles> eight(8, {of_a, of_b});
        const CornersOfPairs corners = corners_of(eight);
        for (const Kernel& kernel : kernels()) {
            double nearest2[8]{};
            const PairVerdicts verdicts =
                kernel.judge(corners, b_to_a.rotation.data(), b_to_a.translation.data(), nearest2);
            EXPECT_EQ(verdicts.separate, 0u) << kernel.name << ": they meet";
        }
    }
}

INSTANTIATE_TEST_SUITE_P(TriangleKernel, EveryFamilyInEights, testing::ValuesIn(triangle_families()),
                         [](const auto& family) { return test_name(family.param); });

} // namespace
} // namespace oncollide
