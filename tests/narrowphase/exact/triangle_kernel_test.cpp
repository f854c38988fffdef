// Eight pairs of triangles at a time, compared with the exact test of one pair.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/kernels/segment_kernel.hpp>
#include <oncollide/narrowphase/exact/kernels/triangle_kernel.hpp>
#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>

#include "verify/cases/triangle_families.hpp"

namespace oncollide::triangle_kernel_test {
namespace {

struct Kernel {
    std::string name;
    JudgePairs* judge;
    CommonSegments* segments;
    MeasurePairs* measure;
};

std::vector<Kernel> kernels()
{
    std::vector<Kernel> all{
        {"baseline", baseline::judge_pairs(), baseline::common_segments(), baseline::measure_pairs()}};
    if (instruction_set() >= InstructionSet::avx2)
        all.push_back({"avx2", avx2::judge_pairs(), avx2::common_segments(), avx2::measure_pairs()});
    if (instruction_set() >= InstructionSet::avx512)
        all.push_back({"avx512", avx512::judge_pairs(), avx512::common_segments(), avx512::measure_pairs()});
    return all;
}

double extent_of(const TwoTriangles& pair)
{
    double extent = 0;
    for (const Eigen::Vector3d& p : pair.first)
        for (const Eigen::Vector3d& q : pair.second) extent = std::max(extent, (p - q).norm());
    return extent;
}

/// Rotations, scales, and axes so different that only some products of coordinates underflow or overflow.
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

/// Whether the filter is designed for this scale.
bool ordinary(const Eigen::Matrix3d& map)
{
    return map.norm() < 1e20 && map.norm() > 1e-20;
}

CornersOfPairs corners_of(const std::vector<TwoTriangles>& eight)
{
    CornersOfPairs corners;
    for (unsigned i = 0; i < 8; ++i)
        for (unsigned k = 0; k < 3; ++k)
            corners.a[k][i] = eight[i].first[k].data(), corners.b[k][i] = eight[i].second[k].data();
    return corners;
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
                    kernel.judge(corners, stay.rotation.data(), stay.translation.data(), &nearest2);
                const PairVerdicts without_gaps =
                    kernel.judge(corners, stay.rotation.data(), stay.translation.data(), nullptr);
                for (unsigned i = 0; i < count; ++i) {
                    const bool separate = verdicts.separate >> i & 1, known = verdicts.known >> i & 1;
                    EXPECT_TRUE(known || !separate) << kernel.name;
                    if (without_gaps.known >> i & 1) {
                        EXPECT_EQ(without_gaps.separate >> i & 1, !truth[i]) << kernel.name << " map\n" << map;
                    }
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

/// The common points of a pair, as returned by a kernel; not transformed.
struct Common {
    bool found;
    Eigen::Vector3d ends[2], normal_a, normal_b;

    friend bool operator==(const Common&, const Common&) = default;
};
Common common(const SegmentsOfPairs& all, unsigned found, unsigned i)
{
    if (!(found >> i & 1)) return {false, {{0, 0, 0}, {0, 0, 0}}, {0, 0, 0}, {0, 0, 0}};
    const auto vector = [&](const double(&v)[3][8]) { return Eigen::Vector3d(v[0][i], v[1][i], v[2][i]); };
    return {true, {vector(all.ends[0]), vector(all.ends[1])}, vector(all.normal_a), vector(all.normal_b)};
}

TEST_P(EveryFamilyInEights, HasTheSegmentAndNormalsOfTheExactTestOrIsLeftOpen)
{
    const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
    const double nowhere[3] = {0, 0, 0};
    const RigidMap stay{unit.data(), nowhere};
    for (const Eigen::Matrix3d& map : maps()) {
        GridPoints random(31);
        int crossing = 0, found = 0;
        for (unsigned turn = 0; turn < 40; ++turn) {
            std::vector<TwoTriangles> eight;
            for (unsigned i = 0; i < 8; ++i) // some far from the origin
                eight.push_back(moved(GetParam().make(random), map, map * random.point(i < 4 ? 0 : 1 << 22)));
            const CornersOfPairs corners = corners_of(eight);
            std::vector<Common> first;
            for (const Kernel& kernel : kernels()) {
                SegmentsOfPairs all;
                const unsigned mask = kernel.segments(corners, stay, stay, all);
                for (unsigned i = 0; i < 8; ++i) {
                    const Common c = common(all, mask, i);
                    if (first.size() == i) first.push_back(c);
                    EXPECT_EQ(c, first[i]) << kernel.name << ": the same on every instruction set";
                }
            }
            for (unsigned i = 0; i < 8; ++i) {
                const auto& [a, b] = eight[i];
                const bool cross = triangle_contact(a, b) == TriangleContact::crossing;
                crossing += cross, found += first[i].found;
                if (!first[i].found) continue;
                ASSERT_TRUE(cross) << shown(eight[i]);
                const CommonSegment truth = common_segment(a, b);
                double largest = 0;
                for (const TrianglePoints* t : {&a, &b})
                    for (const Eigen::Vector3d& p : *t) largest = std::max(largest, p.cwiseAbs().maxCoeff());
                const auto off = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
                    return (p / largest - q / largest).cwiseAbs().maxCoeff();
                };
                const double as_they_are =
                    std::max(off(first[i].ends[0], truth.ends[0]), off(first[i].ends[1], truth.ends[1]));
                const double rotated =
                    std::max(off(first[i].ends[0], truth.ends[1]), off(first[i].ends[1], truth.ends[0]));
                EXPECT_LE(std::min(as_they_are, rotated), 0x1p-46 + 0x1p-48) << shown(eight[i]);
                const Eigen::Vector3d normal_a = unit_normal(a[0], a[1], a[2]),
                                      normal_b = unit_normal(b[0], b[1], b[2]);
                EXPECT_LE((first[i].normal_a - normal_a).cwiseAbs().maxCoeff(), 0x1p-40 + 0x1p-49) << shown(eight[i]);
                EXPECT_LE((first[i].normal_b - normal_b).cwiseAbs().maxCoeff(), 0x1p-40 + 0x1p-49) << shown(eight[i]);
            }
        }
        if (GetParam().name == "random large" && ordinary(map)) {
            EXPECT_GT(crossing, 10);
            EXPECT_GE(found, 0.8 * crossing) << "a filter that knows";
        }
    }
}

TEST(TriangleKernel, MovesSegmentsToTheWorld)
{
    GridPoints random(41);
    const Eigen::Matrix3d rotation = random.rotation();
    const Eigen::Isometry3d a = Eigen::Translation3d(3, 1, 2) * Eigen::Isometry3d(rotation), b(random.rotation());
    const RelativePose b_to_a(a, b);
    const Eigen::Vector3d translation = a.translation();
    const TrianglePoints flat{Eigen::Vector3d(-4, -4, 0), Eigen::Vector3d(4, -4, 0), Eigen::Vector3d(0, 4, 0)};
    const TrianglePoints steep{Eigen::Vector3d(-1, 0, -1), Eigen::Vector3d(1, 0, -1), Eigen::Vector3d(0, 0, 1)};
    TwoTriangles pair{flat, steep}; // in the world frame; they share the segment from (-1/2, 0, 0) to (1/2, 0, 0)
    for (Eigen::Vector3d& p : pair.first) p = a.inverse() * p;
    for (Eigen::Vector3d& p : pair.second) p = b.inverse() * p;
    const std::vector<TwoTriangles> eight(8, pair);
    const CornersOfPairs corners = corners_of(eight);
    for (const Kernel& kernel : kernels()) {
        SegmentsOfPairs all;
        ASSERT_EQ(kernel.segments(corners, {b_to_a.rotation.data(), b_to_a.translation.data()},
                                  {rotation.data(), translation.data()}, all),
                  255u)
            << kernel.name;
        for (unsigned i = 0; i < 8; ++i) {
            const Common c = common(all, 255, i);
            EXPECT_NEAR(std::abs(c.ends[0].x()), 0.5, 1e-14);
            EXPECT_LT((c.ends[0] + c.ends[1]).norm(), 1e-14);
            EXPECT_LT(std::abs(c.ends[0].y()) + std::abs(c.ends[0].z()), 1e-14);
            EXPECT_LT((c.normal_a - Eigen::Vector3d::UnitZ()).norm(), 1e-14);
            EXPECT_LT((c.normal_b + Eigen::Vector3d::UnitY()).norm(), 1e-14);
        }
    }
}

TEST_P(EveryFamilyInEights, HasNearestPointsThatASlabProvesAndTheSameBitsOnEveryInstructionSet)
{
    GridPoints random(13);
    const RelativePose rotated(Eigen::Isometry3d(random.rotation()), Eigen::Isometry3d(random.rotation()));
    std::size_t proved = 0;
    for (unsigned turn = 0; turn < 200; ++turn) {
        std::vector<TwoTriangles> eight;
        for (unsigned i = 0; i < 8; ++i) eight.push_back(GetParam().make(random));
        const CornersOfPairs corners = corners_of(eight);
        const unsigned count = 1 + turn % 8;
        std::vector<NearestOfPairs> found;
        for (const Kernel& kernel : kernels()) {
            kernel.measure(corners, rotated.rotation.data(), rotated.translation.data(), count,
                           std::numeric_limits<double>::infinity(), found.emplace_back());
            for (unsigned i = 0; i < count; ++i) {
                const NearestPoints here = points_of(found.back(), i), first = points_of(found.front(), i);
                EXPECT_TRUE(here.a == first.a && here.b == first.b && here.distance == first.distance) << kernel.name;
            }
        }
        for (unsigned i = 0; i < count; ++i) {
            auto& [p, q] = eight[i];
            for (Eigen::Vector3d& corner : q) corner = rotated(corner);
            if (triangles_meet(p, q)) continue;
            const NearestPoints points = points_of(found.front(), i);
            const double rounding = 0x1p-40 * extent_of(eight[i]);
            EXPECT_NEAR(points.distance, (points.b - points.a).norm(), rounding);
            EXPECT_EQ(points.distance, triangle_distance(p, q)) << "one pair alone";
            EXPECT_LE(points.distance, corner_distance(p, q) + rounding);
            if (points.distance < 1e-3 * extent_of(eight[i])) continue; // the line is known too inaccurately
            const Eigen::Vector3d line = (points.b - points.a) / points.distance;
            EXPECT_GE(least_along(line, q) - most_along(line, p), points.distance - 8 * rounding);
            EXPECT_NEAR(line.dot(points.a), most_along(line, p), 8 * rounding);
            EXPECT_NEAR(line.dot(points.b), least_along(line, q), 8 * rounding);
            ++proved;
        }
    }
    EXPECT_GT(proved, 200u);
}

/// Edges that cross at 2^-26 rad: the nearest points in doubles are far off, and no slab shows their distance.
TEST(TriangleKernel, SaysWhichDistancesItCannotShow)
{
    const double tan = 0x1p-26, height = 0x1p-38;
    const TrianglePoints low{Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, -1)};
    const TrianglePoints high{Eigen::Vector3d(-1, -tan, height), Eigen::Vector3d(1, tan, height),
                              Eigen::Vector3d(0, 1, 1)};
    const TrianglePoints far{Eigen::Vector3d(-1, 0, 3), Eigen::Vector3d(1, 0, 3), Eigen::Vector3d(0, 1, 4)};
    const std::vector<TwoTriangles> pairs{{low, far}, {low, high}, {high, far}, {high, low},
                                          {low, far}, {low, far},  {low, far},  {low, high}};
    const CornersOfPairs corners = corners_of(pairs);
    const RelativePose here(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity());
    const auto unsure = [&](const Kernel& kernel, double rounding) {
        NearestOfPairs found;
        return kernel.measure(corners, here.rotation.data(), here.translation.data(), 8, rounding, found);
    };
    for (const Kernel& kernel : kernels()) {
        EXPECT_EQ(unsure(kernel, 0x1p-44) & 0b01110101, 0u) << kernel.name;
        EXPECT_EQ(unsure(kernel, 1), 0u) << kernel.name << ": every distance is larger than this one minus 1 m";
    }
    EXPECT_EQ(triangle_distance(low, high), height);
    NearestOfPairs found;
    measure_pairs(corners, here, 8, 0x1p-44, found);
    for (const unsigned i : {1u, 3u, 7u}) EXPECT_NEAR(points_of(found, i).distance, height, 0x1p-44);
}

TEST(TriangleKernel, MovesPointsToTheLastBitAsTheExactTestIsTold)
{
    // Triangles of B that, after the transform, end exactly on, or one ulp above, a corner of A.
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
                kernel.judge(corners, b_to_a.rotation.data(), b_to_a.translation.data(), &nearest2);
            EXPECT_EQ(verdicts.separate, 0u) << kernel.name << ": they meet";
        }
    }
}

INSTANTIATE_TEST_SUITE_P(TriangleKernel, EveryFamilyInEights, testing::ValuesIn(triangle_families()),
                         [](const auto& family) { return test_name(family.param); });

} // namespace
} // namespace oncollide::triangle_kernel_test
