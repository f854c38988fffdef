// Every instruction set must give the same bits: the result hash depends on it.
#include <gtest/gtest.h>

#include <cstring>

#include <oncollide/base/cpu_features.hpp>
#include <oncollide/base/random.hpp>
#include <oncollide/broadphase/box_kernel.hpp>
#include <oncollide/narrowphase/spheres/octant_kernel.hpp>
#include <oncollide/narrowphase/spheres/surface.hpp>
#include <oncollide/scenes/model/mesh_generators.hpp>

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

TEST(Kernels, BoundPointsAlikeOnEveryInstructionSet)
{
    std::vector<float> x, y, z;
    for (std::uint64_t i = 0; i < 1024; ++i)
        x.push_back(random_float(i, 0)), y.push_back(random_float(i, 1)), z.push_back(random_float(i, 2));
    for (std::uint64_t i = 0; i < 100; ++i) {
        float rows[9], expected[6], got[6];
        for (std::uint64_t k = 0; k < 9; ++k) rows[k] = random_float(i, k);
        const auto ask = [&](const BoxKernel& kernel, float out[6]) {
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
        ask(baseline::box_kernel(), expected);
        if (instruction_set() >= InstructionSet::avx2) {
            ask(avx2::box_kernel(), got);
            EXPECT_EQ(std::memcmp(expected, got, sizeof got), 0);
        }
        if (instruction_set() >= InstructionSet::avx512) {
            ask(avx512::box_kernel(), got);
            EXPECT_EQ(std::memcmp(expected, got, sizeof got), 0);
        }
    }
}

} // namespace
} // namespace oncollide
