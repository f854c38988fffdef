// Every instruction set must give the same bits: the result hash depends on it.
#include <gtest/gtest.h>

#include <cstring>
#include <numeric>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/broadphase/aabb_kernel.hpp>
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
        for (std::uint64_t axis = 0; axis < 3; ++axis) xyz[axis].push_back(random_float(std::min(i, 499ul), axis));
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

} // namespace
} // namespace oncollide
