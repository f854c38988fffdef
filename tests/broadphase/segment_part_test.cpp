// Parts of segments in boxes.
#include <algorithm>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/broadphase/segment_part.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;

TEST(SegmentPart, HoldsThePointsInTheBox)
{
    int inside = 0, missed = 0;
    for (const double far : {0.0, 1e12})
        for (std::uint64_t i = 0; i < 2000; ++i) {
            const auto at = [&](std::uint64_t k, double reach) {
                return Vector3d(reach * Vector3d(u01(i, k, 0) - 0.5, u01(i, k, 1) - 0.5, u01(i, k, 2) - 0.5));
            };
            Aabb box;
            box.add(at(0, 2)), box.add(at(1, 2));
            Segment segment{at(2, 4) - far * at(3, 1), at(4, 4)};
            if (i % 5 == 0) segment.to.z() = segment.from.z();
            if (i % 7 == 0) segment.to = segment.from;
            const std::optional<SegmentPart> part = part_in(segment, box);
            missed += !part;
            for (int k = 0; k <= 64; ++k) {
                const double t = k / 64.0;
                const Vector3d point = segment.from + t * (segment.to - segment.from);
                if ((point.array() < box.min.array()).any() || (point.array() > box.max.array()).any()) continue;
                ++inside;
                ASSERT_TRUE(part) << i;
                EXPECT_GE(t, part->begin - 0x1p-40);
                EXPECT_LE(t, part->end + 0x1p-40);
                const double along =
                    part->half.squaredNorm() > 0 ? part->half.dot(point - part->middle) / part->half.squaredNorm() : 0;
                const Vector3d nearest = part->middle + std::clamp(along, -1.0, 1.0) * part->half;
                EXPECT_LE((nearest - point).norm(), part->error + 1e-15) << i;
            }
        }
    EXPECT_GT(inside, 1000);
    EXPECT_GT(missed, 1000);
}

TEST(SegmentPart, ClipsASegmentFromFarAwayToTheBox)
{
    const std::optional<SegmentPart> part = part_in({{-1e9, 0.5, 0.5}, {1e9, 0.5, 0.5}}, {{0, 0, 0}, {1, 1, 1}});
    ASSERT_TRUE(part);
    EXPECT_NEAR(part->middle.x(), 0.5, 1e-6);
    EXPECT_NEAR(part->half.x(), 0.5, 1e-4);
    const SegmentLine line = line_of(*part, {0.5, 0.5, 0.5}, 2);
    EXPECT_NEAR(line.middle[0], 0, 1e-4);
    EXPECT_EQ(line.direction[0], 1);
    EXPECT_GT(line.error, 0);
    EXPECT_LT(line.error, 1e-3);
}

} // namespace
} // namespace oncollide
