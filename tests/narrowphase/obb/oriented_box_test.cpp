// The largest projection of eight boxes onto a direction, on every instruction set.
#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/obb/oriented_box.hpp>

#include "random_pose.hpp"

namespace oncollide::oriented_box_test {
namespace {

using Eigen::Vector3d;

TEST(OrientedBoxKernel, ReachesTheFarthestCornerOfTheBoxesThatExist)
{
    std::vector<OrientedBoxKernel> kernels{baseline::oriented_box_kernel()};
    if (instruction_set() >= InstructionSet::avx2) kernels.push_back(avx2::oriented_box_kernel());
    if (instruction_set() >= InstructionSet::avx512) kernels.push_back(avx512::oriented_box_kernel());
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
        const unsigned count = 1 + seed % 8;
        OpenBoxes boxes{};
        const Vector3d along = random_pose(seed, 1).linear().col(0);
        const float direction[3] = {float(along.x()), float(along.y()), float(along.z())};
        double farthest = -std::numeric_limits<double>::infinity();
        for (unsigned k = 0; k < 8; ++k) {
            const Eigen::Isometry3d pose = random_pose(1000 + 8 * seed + k, 5);
            Vector3d half;
            for (int i = 0; i < 3; ++i) {
                half[i] = u01(seed, k, std::uint64_t(i));
                boxes.c[i][k] = k < count ? float(pose.translation()[i]) : 1e30f, boxes.h[i][k] = float(half[i]);
                for (int j = 0; j < 3; ++j) boxes.axis[j][i][k] = float(pose.linear()(i, j));
            }
            for (unsigned corner = 0; k < count && corner < 8; ++corner) {
                Vector3d at = half;
                for (unsigned i = 0; i < 3; ++i)
                    if (corner >> i & 1) at[i] = -at[i];
                farthest = std::max(farthest, along.dot(pose * at));
            }
        }
        const float reach = kernels.front().reach(boxes, direction);
        EXPECT_NEAR(reach, farthest, 1e-5) << seed;
        for (const OrientedBoxKernel& kernel : kernels) EXPECT_EQ(kernel.reach(boxes, direction), reach) << seed;
    }
}

} // namespace
} // namespace oncollide::oriented_box_test
