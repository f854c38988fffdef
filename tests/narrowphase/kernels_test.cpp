// Every instruction set must give the same bits: the result hash depends on it.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

#include <Eigen/Geometry>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/broadphase/aabb_kernel.hpp>
#include <oncollide/narrowphase/obb/oriented_box_kernel.hpp>
#include <oncollide/narrowphase/spheres/octant_kernel.hpp>
#include <oncollide/narrowphase/spheres/surface.hpp>
#include <oncollide/samples/generators.hpp>

#include "narrowphase/geometry_surface.hpp"

namespace oncollide {
namespace {

float random_float(std::uint64_t i, std::uint64_t k)
{
    return static_cast<float>(u01(3, i, k) - 0.5);
}

TEST(Kernels, TestOctantsAlikeOnEveryInstructionSet)
{
    const Geometry geometry{"soup", make_soup_mesh(2000, 0.3, 2, 5), {}};
    const Surface surface = make_surface(geometry, root_cell_of(geometry));
    const auto n = static_cast<std::uint32_t>(surface.primitives.size());
    const auto ask = [&](OctantTest* test, const OctantCell& cell) {
        std::vector<std::uint32_t> ids(n);
        std::vector<std::uint8_t> masks(n);
        const std::uint32_t found =
            test(surface.primitives.data(), false, {nullptr, nullptr, n, 0}, cell, ids.data(), masks.data());
        ids.resize(found), masks.resize(found);
        return std::pair(ids, masks);
    };
    std::size_t grey = 0;
    for (std::uint64_t i = 0; i < 200; ++i) {
        OctantCell cell{{random_float(i, 0), random_float(i, 1), random_float(i, 2)}, {0.1f, 0.07f, 0.2f}, 1e-6f};
        const auto expected = ask(baseline::octant_test(), cell);
        grey += expected.first.size();
        if (instruction_set() >= InstructionSet::avx2) {
            EXPECT_EQ(ask(avx2::octant_test(), cell), expected);
        }
    }
    EXPECT_GT(grey, 1000u);
}

TEST(Kernels, KeepThePointsThatMayBeFarthestOnEveryInstructionSet)
{
    constexpr std::uint32_t count = 500;
    std::vector<float> xyz[3], along(5 * 504);
    for (std::uint64_t i = 0; i < 504; ++i)
        for (std::uint64_t axis = 0; axis < 3; ++axis) xyz[axis].push_back(random_float(std::min<std::uint64_t>(i, 499), axis));
    const float corners[4][3] = {{0.9f, 0, 0.1f}, {0.9f, 0.2f, 0}, {0.8f, 0, 0.3f}, {0.8f, 0.2f, 0.2f}};
    std::vector<std::int32_t> expected(504);
    baseline::aabb_kernel().keep_farthest(xyz[0].data(), xyz[1].data(), xyz[2].data(), count, corners, 1e-6f,
                                          along.data(), expected.data());
    const auto kept = std::accumulate(expected.begin(), expected.begin() + count, 0);
    EXPECT_TRUE(kept > 0 && kept < 50) << kept;
    const auto most = [&](const float(&d)[3]) { // the farthest of them
        std::size_t best = 0;
        const auto of = [&](std::size_t i) { return d[0] * xyz[0][i] + d[1] * xyz[1][i] + d[2] * xyz[2][i]; };
        for (std::size_t i = 1; i < count; ++i)
            if (of(i) > of(best)) best = i;
        return best;
    };
    for (const auto& corner : corners) EXPECT_EQ(expected[most(corner)], 1);
    EXPECT_EQ(expected[most({0.85f, 0.1f, 0.15f})], 1);
    std::vector<std::int32_t> got(504);
    for (const auto& [set, kernel] : {std::pair(InstructionSet::avx2, &avx2::aabb_kernel),
                                      std::pair(InstructionSet::avx512, &avx512::aabb_kernel)}) {
        if (instruction_set() < set) continue;
        kernel().keep_farthest(xyz[0].data(), xyz[1].data(), xyz[2].data(), count, corners, 1e-6f, along.data(),
                               got.data());
        EXPECT_EQ(got, expected);
    }
}

TEST(Kernels, BoundPointsAlikeOnEveryInstructionSet)
{
    std::vector<float> x, y, z;
    for (std::uint64_t i = 0; i < 1024; ++i)
        x.push_back(random_float(i, 0)), y.push_back(random_float(i, 1)), z.push_back(random_float(i, 2));
    for (std::uint64_t i = 0; i < 100; ++i) {
        float rows[9], expected[6], got[6];
        for (std::uint64_t k = 0; k < 9; ++k) rows[k] = random_float(i, k);
        const auto ask = [&](const AabbKernel& kernel, float out[6]) {
            kernel.support_box(x.data(), y.data(), z.data(), 1024, rows, out, out + 3);
            for (int axis = 0; axis < 3; ++axis)
                EXPECT_EQ(kernel.most_along(x.data(), y.data(), z.data(), 1024, rows + 3 * axis), out[3 + axis]);
            const PointRange all{0, 1021}, lists[] = {all, all, all, all, {8, 1013}, {0, 8}}; // padded
            float low[3], high[3], first[3], rest[3];
            kernel.lists_box(x.data(), y.data(), z.data(), lists, rows, low, high);
            kernel.support_box(x.data(), y.data(), z.data(), 8, rows, first, rest);
            EXPECT_EQ(low[2], first[2]);
            EXPECT_EQ(std::max(high[2], rest[2]), out[5]);
            EXPECT_TRUE(std::equal(low, low + 2, out) && std::equal(high, high + 2, out + 3));
        };
        ask(baseline::aabb_kernel(), expected);
        if (instruction_set() >= InstructionSet::avx2) {
            ask(avx2::aabb_kernel(), got);
            EXPECT_EQ(std::memcmp(expected, got, sizeof got), 0);
        }
        if (instruction_set() >= InstructionSet::avx512) {
            ask(avx512::aabb_kernel(), got);
            EXPECT_EQ(std::memcmp(expected, got, sizeof got), 0);
        }
    }
}

/// Eight boxes of any rotation around points in a cube of side 1; the last lane is unused.
OpenBoxes random_boxes(std::uint64_t seed)
{
    OpenBoxes boxes{};
    for (unsigned k = 0; k < 8; ++k) {
        Eigen::Vector4f q;
        for (std::uint64_t i = 0; i < 4; ++i) q[int(i)] = random_float(8 * seed + k, 20 + i);
        const Eigen::Matrix3f r = Eigen::Quaternionf(q.normalized()).toRotationMatrix();
        for (int i = 0; i < 3; ++i) {
            boxes.c[i][k] = k == 7 ? 1e30f : random_float(8 * seed + k, std::uint64_t(i));
            boxes.h[i][k] = 0.2f * std::abs(random_float(8 * seed + k, 10 + std::uint64_t(i)));
            for (int j = 0; j < 3; ++j) boxes.axis[j][i][k] = r(i, j);
            boxes.size[k] += boxes.h[i][k] * boxes.h[i][k];
        }
    }
    return boxes;
}

TEST(Kernels, FindWhenMovingBoxesMeetOnEveryInstructionSet)
{
    int meet = 0, never = 0;
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
        const OpenBoxes boxes = random_boxes(2 * seed), other = random_boxes(2 * seed + 1);
        BoxMotion motion{.base = {}, .turn = {}, .turn_length = 0, .slack = 1e-6f};
        for (std::uint64_t i = 0; i < 3; ++i)
            motion.base[i] = 2 * random_float(seed, 40 + i), motion.turn[i] = 0.4f * random_float(seed, 50 + i);
        motion.turn_length = Eigen::Map<const Eigen::Vector3f>(motion.turn).norm() * 1.00001f;
        float expected[8], got[8];
        const unsigned k = seed % 7;
        const unsigned found = baseline::oriented_box_kernel().meet_in_time(boxes, other, k, motion, 1, expected);
        EXPECT_FALSE(found >> 7 & 1) << "the unused lane";
        for (const auto& [set, kernel] : {std::pair(InstructionSet::avx2, &avx2::oriented_box_kernel),
                                          std::pair(InstructionSet::avx512, &avx512::oriented_box_kernel)}) {
            if (instruction_set() < set) continue;
            EXPECT_EQ(kernel().meet_in_time(boxes, other, k, motion, 1, got), found);
            EXPECT_EQ(std::memcmp(expected, got, sizeof(float) * 7), 0);
        }
        // Boxes that overlap at a time, as moved by then, meet no later.
        unsigned overlapped = 0;
        for (int n = 0; n <= 64; ++n) {
            const float time = float(n) / 32 - 1;
            OpenBoxes moved = boxes;
            for (unsigned lane = 0; lane < 7; ++lane) {
                const Eigen::Vector3f c(boxes.c[0][lane], boxes.c[1][lane], boxes.c[2][lane]),
                    v = Eigen::Map<const Eigen::Vector3f>(motion.base) +
                        Eigen::Map<const Eigen::Vector3f>(motion.turn).cross(c);
                for (int i = 0; i < 3; ++i) moved.c[i][lane] = c[i] + time * v[i];
            }
            float gaps[8], nearest[8] = {};
            const unsigned near = baseline::oriented_box_kernel().compare(moved, other, k, 0, gaps, nearest);
            overlapped |= near;
            for (unsigned lane = 0; lane < 7; ++lane)
                if (near >> lane & 1) {
                    EXPECT_TRUE(found >> lane & 1 && expected[lane] <= time + 1e-6f) << seed << " " << lane;
                }
        }
        meet += std::popcount(overlapped), never += 7 - std::popcount(found);
    }
    EXPECT_GT(meet, 50);
    EXPECT_GT(never, 300);
}

} // namespace
} // namespace oncollide
