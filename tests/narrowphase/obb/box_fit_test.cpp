// Boxes that are fitted together: each holds its triangles and follows their spread, alike on every instruction set.
#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/obb/fits/box_fit.hpp>
#include <oncollide/narrowphase/obb/oriented_box.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;
using Triangles = std::vector<TrianglePoints>;
using EightBoxes = std::array<Triangles, 8>;

Vector3d random_point(std::uint64_t i, std::uint64_t k)
{
    return {u01(i, k, 0) - 0.5, u01(i, k, 1) - 0.5, u01(i, k, 2) - 0.5};
}

/// A patch of a rotated plane, of 3 times 1 cells, with the given height across it.
Triangles patch(std::uint64_t seed, int cells, double height)
{
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(3 * u01(seed, 9, 9), random_point(seed, 8).normalized()));
    const auto at = [&](int i, int k) -> Vector3d {
        const auto number = static_cast<std::uint64_t>(100 * i + k);
        return turn * Vector3d(0.9 * i / cells, 0.3 * k / cells, height * u01(seed, 7, number)) + random_point(seed, 6);
    };
    Triangles all;
    for (int i = 0; i < cells; ++i)
        for (int k = 0; k < cells; ++k) {
            all.push_back({at(i, k), at(i + 1, k), at(i + 1, k + 1)});
            all.push_back({at(i, k), at(i + 1, k + 1), at(i, k + 1)});
        }
    return all;
}

/// Boxes of many, two, one and no triangles; needles, points and triangles that are in a line.
std::vector<EightBoxes> cases()
{
    std::vector<EightBoxes> all;
    for (std::uint64_t i = 0; i < 100; ++i) {
        EightBoxes boxes;
        boxes[0] = patch(i, 4, 1e-3), boxes[1] = patch(i + 100, 3, 0);
        for (std::uint64_t k = 0; k < 1 + i % 40; ++k)
            boxes[2].push_back({random_point(i, k), random_point(i, k + 50), random_point(i, k + 100)});
        boxes[3] = {boxes[2][0]};
        const Vector3d p = random_point(i, 200), q = random_point(i, 201);
        boxes[4] = {{p, q, p + 1e-9 * random_point(i, 202)}, {p, p, p}};
        boxes[5] = {{p, q, 0.5 * (p + q)}};
        if (i % 2 == 0) boxes[6] = {{p, p, p}};
        if (i % 10 == 0) boxes[7] = patch(i + 200, 13, 0.01); // fitted alone
        all.push_back(boxes);
    }
    return all;
}

BoxNode fitted(const EightBoxes& boxes, double radius = 1)
{
    BoxNode node{};
    set_frame(node, Vector3d(0.1, 0.2, -0.1), 2 * radius);
    node.lanes = 8;
    std::array<std::uint32_t, 8> counts;
    std::ranges::transform(boxes, counts.begin(), [](const Triangles& t) { return std::uint32_t(t.size()); });
    BoxFit fit;
    set_boxes(node, fit.fit(counts, frame_of(node), [&](unsigned k, std::uint32_t i) { return boxes[k][i]; }));
    return node;
}

TEST(FittedBoxes, HoldTheirTriangles)
{
    for (const EightBoxes& boxes : cases()) {
        const BoxNode node = fitted(boxes);
        for (unsigned k = 0; k < 8; ++k)
            for (const TrianglePoints& t : boxes[k])
                for (const Vector3d& p : t) ASSERT_TRUE(holds(node, k, p)) << "box " << k;
    }
}

TEST(FittedBoxes, AreZeroWithoutTriangles)
{
    const BoxNode node = fitted(cases()[1]);
    for (const unsigned k : {6u, 7u}) {
        EXPECT_TRUE(node.x[k] == 0 && node.y[k] == 0 && node.z[k] == 0);
        EXPECT_TRUE(node.qw[k] == 0 && node.qx[k] == 0 && node.qy[k] == 0 && node.qz[k] == 0);
        EXPECT_TRUE(node.hx[k] == 0 && node.hy[k] == 0 && node.hz[k] == 0);
    }
}

TEST(FittedBoxes, FollowTheSurface)
{
    for (const EightBoxes& boxes : cases()) {
        const BoxNode node = fitted(boxes);
        const auto sides = [&](unsigned k) {
            std::array<double, 3> h{double(node.hx[k]), double(node.hy[k]), double(node.hz[k])};
            std::ranges::sort(h);
            for (double& side : h) side *= 2 * node.unit;
            return h;
        };
        const auto flat = sides(1); // a rectangle of 0.9 by 0.3
        EXPECT_LT(flat[0], 0.002);
        EXPECT_NEAR(flat[1], 0.3, 0.003);
        EXPECT_NEAR(flat[2], 0.9, 0.003);
        EXPECT_LT(sides(0)[0], 0.004);
        EXPECT_LT(sides(4)[1], 0.002) << "a needle";
        EXPECT_LT(sides(5)[1], 0.002) << "a line";
        const TrianglePoints& t = boxes[3][0];
        const double longest = std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
        const double height = (t[1] - t[0]).cross(t[2] - t[0]).norm() / longest;
        EXPECT_LT(sides(3)[0], 0.002);
        EXPECT_NEAR(sides(3)[1] * sides(3)[2], longest * height, 0.006) << "one triangle";
    }
}

TEST(FittedBoxes, DoNotDependOnTheOrderOfTrianglesAndCorners)
{
    for (EightBoxes boxes : cases()) {
        const BoxNode before = fitted(boxes);
        for (Triangles& triangles : boxes) {
            std::ranges::reverse(triangles);
            for (TrianglePoints& t : triangles) std::swap(t[0], t[2]), std::swap(t[1], t[2]);
        }
        const BoxNode after = fitted(boxes);
        ASSERT_EQ(std::memcmp(&before, &after, sizeof before), 0);
    }
}

EightTriangles random_row(std::uint64_t seed)
{
    EightTriangles row;
    for (std::uint64_t k = 0; k < 8; ++k)
        for (std::uint64_t c = 0; c < 3; ++c)
            for (std::uint64_t axis = 0; axis < 3; ++axis) row.corners[c][axis][k] = u01(seed, k, 3 * c + axis);
    return row;
}

TEST(FittedBoxes, AreTheSameOverOneLaneAndOverEight)
{
    constexpr StoredFrame frame{{0.1f, 0, 0.2f}, 1e-4f};
    for (std::uint32_t count = 8; count < 300; count += count < 40 ? 1 : 37) {
        std::vector<EightTriangles> eight((count + 7) / 8), one(count);
        std::uint32_t of_eight[8] = {}, of_one[8] = {};
        for (std::uint32_t i = 0; i < 8 * eight.size(); ++i) {
            const EightTriangles from = random_row(i < count ? i : 0);
            for (int c = 0; c < 3; ++c)
                for (int axis = 0; axis < 3; ++axis) {
                    const double at = axis == 2 && count % 3 == 0 ? 0 : from.corners[c][axis][0] * (axis + 1);
                    eight[i / 8].corners[c][axis][i % 8] = at;
                    for (int k = 0; k < 8 && i < count; ++k) one[i].corners[c][axis][k] = at;
                }
            if (i < count) ++of_eight[i % 8], ++of_one[5];
        }
        StoredBoxes alone, together;
        box_fit_kernel().fit_one(eight.data(), of_eight, frame, alone);
        box_fit_kernel().fit(one.data(), of_one, frame, together);
        for (int k = 0; k < 8; ++k) {
            for (int i = 0; i < 3; ++i) ASSERT_EQ(alone.place[i][k], together.place[i][5]) << count;
            for (int i = 0; i < 3; ++i) ASSERT_EQ(alone.half[i][k], together.half[i][5]) << count;
            for (int i = 0; i < 4; ++i) ASSERT_EQ(alone.turn[i][k], together.turn[i][5]) << count;
        }
    }
}

TEST(FittedBoxes, AreAlikeOnEveryInstructionSet)
{
    if (instruction_set() < InstructionSet::avx2) GTEST_SKIP() << "only one instruction set";
    for (std::uint64_t i = 0; i < 200; ++i) {
        std::vector<EightTriangles> rows(1 + i % 20);
        std::uint32_t counts[8];
        for (std::uint64_t k = 0; k < 8; ++k) {
            counts[k] = static_cast<std::uint32_t>(double(rows.size() + 1) * u01(i, k, 99));
            for (std::uint64_t row = 0; row < rows.size(); ++row)
                for (std::uint64_t c = 0; c < 3; ++c)
                    for (std::uint64_t axis = 0; axis < 3; ++axis)
                        rows[row].corners[c][axis][k] = u01(i, k, 9 * (row < counts[k] ? row : 0) + 3 * c + axis);
        }
        const StoredFrame frame{{0.1f, 0, 0.2f}, 1e-4f};
        StoredBoxes expected, found;
        baseline::box_fit_kernel().fit(rows.data(), counts, frame, expected);
        avx2::box_fit_kernel().fit(rows.data(), counts, frame, found);
        ASSERT_EQ(std::memcmp(&expected, &found, sizeof found), 0) << "case " << i;
        std::ranges::fill(counts, static_cast<std::uint32_t>(rows.size()));
        baseline::box_fit_kernel().fit_one(rows.data(), counts, frame, expected);
        avx2::box_fit_kernel().fit_one(rows.data(), counts, frame, found);
        ASSERT_EQ(std::memcmp(&expected, &found, sizeof found), 0) << "case " << i;
    }
}

} // namespace
} // namespace oncollide
