// Eight pairs of triangles at a time against the exact test of one.
#include <gtest/gtest.h>

#include <oncollide/broadphase/cpu_features.hpp>
#include <oncollide/narrowphase/triangle_kernel.hpp>

#include "triangle_families.hpp"

namespace oncollide {
namespace {

struct Kernel {
    std::string name;
    JudgePairs* judge;
};

std::vector<Kernel> kernels()
{
    std::vector<Kernel> all{{"baseline", baseline::judge_pairs()}};
    if (instruction_set() >= InstructionSet::avx2) all.push_back({"avx2", avx2::judge_pairs()});
    if (instruction_set() >= InstructionSet::avx512) all.push_back({"avx512", avx512::judge_pairs()});
    return all;
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

void put(const TrianglePoints& triangle, double (&corners)[9])
{
    for (std::size_t k = 0; k < 3; ++k) Eigen::Map<Eigen::Vector3d>(corners + 3 * k) = triangle[k];
}

class EveryFamilyInEights : public testing::TestWithParam<TriangleFamily> {};

TEST_P(EveryFamilyInEights, IsJudgedAsTheExactTestDoesOrLeftOpen)
{
    for (const Eigen::Matrix3d& map : maps()) {
        GridPoints random(11);
        std::size_t open = 0, pairs = 0, meeting = 0;
        for (unsigned turn = 0; turn < 120; ++turn) {
            const unsigned count = turn % 8 + 1;
            double a[8][9], b[8][9];
            std::vector<bool> truth;
            for (unsigned i = 0; i < count; ++i) {
                const auto [p, q] = moved(GetParam().make(random), map, Eigen::Vector3d::Zero());
                put(p, a[i]), put(q, b[i]);
                truth.push_back(triangles_meet(p, q));
                meeting += truth.back();
            }
            pairs += count;
            for (const Kernel& kernel : kernels()) {
                const PairVerdicts verdicts = kernel.judge(a, b, count);
                for (unsigned i = 0; i < count; ++i) {
                    const bool separate = verdicts.separate >> i & 1, known = verdicts.known >> i & 1;
                    EXPECT_TRUE(known || !separate) << kernel.name;
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

INSTANTIATE_TEST_SUITE_P(TriangleKernel, EveryFamilyInEights, testing::ValuesIn(triangle_families()),
                         [](const auto& family) { return test_name(family.param); });

} // namespace
} // namespace oncollide
