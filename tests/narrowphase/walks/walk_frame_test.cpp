#include <limits>

#include <gtest/gtest.h>

#include "random_pose.hpp"

#include <oncollide/narrowphase/walks/walk_frame.hpp>

namespace oncollide::walk_frame_test {
namespace {

struct Ball {
    Eigen::Vector3d at;
    double size;
    Eigen::Vector3d centre() const { return at; }
    double radius() const { return size; }
};

Eigen::Vector3d point_in(const Ball& ball, std::uint64_t seed)
{
    const Eigen::Vector3d p(u01(seed, 7, 0) - 0.5, u01(seed, 7, 1) - 0.5, u01(seed, 7, 2) - 0.5);
    return ball.at + ball.size * u01(seed, 7, 3) * p.normalized();
}

/// The point in the coordinates of the frame, computed in float as boxes are.
Eigen::Vector3d shown(const BoxPlacement& placement, const Eigen::Vector3d& from_centre)
{
    const Eigen::Vector3f p = from_centre.cast<float>() - Eigen::Map<const Eigen::Vector3f>(placement.from);
    if (!placement.rotated) return p.cast<double>();
    const Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> rotation(placement.rotation);
    return (rotation * p + Eigen::Map<const Eigen::Vector3f>(placement.translation)).cast<double>();
}

class WalkFrames : public testing::Test {
protected:
    /// Calls visit(a, b, pose, frame) for small and large, near and far geometries.
    template <class Visit>
    void each(Visit visit) const
    {
        for (std::uint64_t seed = 0; seed < 400; ++seed) {
            const double size_a = std::pow(10, 6 * u01(seed, 3, 0) - 3), size_b = std::pow(10, 6 * u01(seed, 3, 1) - 3);
            const Ball a{random_pose(seed + 1000, 10 * size_a).translation(), size_a},
                b{random_pose(seed + 2000, 10 * size_b).translation(), size_b};
            const RelativePose pose(random_pose(seed + 3000, 2 * (size_a + size_b)), random_pose(seed + 4000, size_a));
            visit(a, b, pose, WalkFrame(a, b, pose, std::numeric_limits<double>::infinity()), seed);
        }
    }
};

TEST_F(WalkFrames, ShowPointsOfBothWhereTheyAreUpToTheirRounding)
{
    each([](const Ball& a, const Ball& b, const RelativePose& pose, const WalkFrame& frame, std::uint64_t seed) {
        for (std::uint64_t k = 0; k < 20; ++k) {
            const Eigen::Vector3d p = point_in(a, seed + k), q = point_in(b, seed + 100 + k);
            // A box of size s may err by the margin of its node as well.
            const double of_a = frame.box_rounding + box_margin * (a.size + (frame.origin - a.at).norm()),
                         of_b = frame.box_rounding + box_margin * (b.size + (frame.origin - pose(b.at)).norm());
            EXPECT_LT((shown(frame.place_a, p - a.at) - (p - frame.origin)).norm(), of_a) << seed;
            EXPECT_LT((shown(frame.place_b, q - b.at) - (pose(q) - frame.origin)).norm(), of_b) << seed;
        }
    });
}

TEST_F(WalkFrames, BeginAtTheCentreOfTheSmallerGeometry)
{
    each([](const Ball& a, const Ball& b, const RelativePose& pose, const WalkFrame& frame, std::uint64_t) {
        const Eigen::Vector3d smaller = a.size < b.size ? a.at : pose(b.at),
                              larger = a.size < b.size ? pose(b.at) : a.at;
        EXPECT_LE((frame.origin - smaller).norm(), 0x1p-22 * (smaller - larger).norm() + 0x1p-48 * smaller.norm());
    });
}

TEST_F(WalkFrames, ProveADistanceThatTheSpheresHave)
{
    int apart = 0;
    each([&](const Ball& a, const Ball& b, const RelativePose& pose, const WalkFrame& frame, std::uint64_t) {
        const double gap = (pose(b.at) - a.at).norm() - a.size - b.size;
        EXPECT_LT(frame.apart, std::max(gap, 0.0));
        EXPECT_GT(frame.apart, gap - 1e-4 * (std::abs(gap) + a.size + b.size));
        apart += frame.apart > 0;
    });
    EXPECT_GT(apart, 20);
}

TEST_F(WalkFrames, BoundAGapAndItsDistanceOnTheSafeSide)
{
    each([](const Ball& a, const Ball& b, const RelativePose&, const WalkFrame& frame, std::uint64_t) {
        for (const double share : {0.0, 1e-6, 1e-3, 1.0, 1e3}) {
            const double distance = share * std::min(a.size, b.size);
            const double gap = double(frame.gap_within(distance));
            EXPECT_GT(gap, distance);
            EXPECT_GE(frame.at_least(gap * (1 + 1e-6)), distance * (1 - 1e-9)) << "a larger gap proves it";
            EXPECT_LT(frame.at_least(gap), gap);
        }
        EXPECT_GT(frame.leaf_rounding, 0);
    });
}

} // namespace
} // namespace oncollide::walk_frame_test
