#include <oncollide/scenes/scene.hpp>

#include <cstring>

#include <gtest/gtest.h>

namespace oncollide {
namespace {

using Eigen::Isometry3d;

Scene balls(std::uint32_t count)
{
    Scene scene;
    const GeometryId ball = scene.add("ball", Sphere{1});
    for (std::uint32_t i = 0; i < count; ++i) scene.add_body({.geometry = ball});
    return scene;
}

bool same_bits(const Isometry3d& a, const Isometry3d& b)
{
    return std::memcmp(a.data(), b.data(), sizeof(double) * 16) == 0;
}

TEST(Columns, GiveEveryPoseBackBitForBit)
{
    Scene scene = balls(3);
    Isometry3d odd = Isometry3d::Identity();
    odd.linear()(0, 1) = -0.0, odd.translation() = Eigen::Vector3d(-0.0, 1e-300, 1e15);
    Isometry3d rotated = odd;
    rotated.linear() = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    for (const Isometry3d& pose : {odd, rotated, Isometry3d(Isometry3d::Identity()), rotated, odd}) {
        scene.set_pose(SceneBodyId{1}, pose);
        EXPECT_TRUE(same_bits(scene.poses[1], pose)) << pose.matrix();
        EXPECT_TRUE(same_bits(scene.poses[0], Isometry3d::Identity()));
        EXPECT_TRUE(same_bits(scene.start_pose(1), Isometry3d::Identity())) << "the first pose stays the start pose";
    }
    scene.add_body({.geometry = GeometryId{0}, .pose = rotated});
    EXPECT_TRUE(same_bits(scene.poses[3], rotated));
    EXPECT_TRUE(same_bits(scene.start_pose(3), rotated)) << "added after others had moved";
    std::size_t walked = 0;
    for (const Isometry3d& pose : scene.poses) EXPECT_TRUE(same_bits(pose, scene.poses[walked++]));
    EXPECT_EQ(walked, 4u);
}

TEST(Columns, HoldNamesWhereTheyAre)
{
    Scene scene = balls(2);
    for (const char* name : {"first", "", "second", "", ""}) scene.add_body({.name = name, .geometry = GeometryId{0}});
    ASSERT_EQ(scene.names.size(), 7u);
    const char* const expected[] = {"", "", "first", "", "second", "", ""};
    for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(scene.names[i], expected[i]) << i;
    EXPECT_EQ(scene.find("second"), SceneBodyId{4});
}

TEST(Columns, HoldMotionsOfThoseThatMove)
{
    Scene scene = balls(2);
    scene.add_body({.geometry = GeometryId{0}, .motion = Drift{.velocity = {1, 0, 0}, .spin = {0, 0, 0}, .walls = {}}});
    scene.add_body({.geometry = GeometryId{0}});
    EXPECT_TRUE(std::holds_alternative<Still>(scene.motions[0]));
    EXPECT_EQ(std::get<Drift>(scene.motions[2]).velocity.x(), 1);
    EXPECT_TRUE(std::holds_alternative<Still>(scene.motions[3]));
    ASSERT_EQ(scene.motions.bodies().size(), 1u);
    EXPECT_EQ(scene.motions.bodies()[0], 2u);
}

TEST(ChangeLog, TellsWhatChangedSinceAMark)
{
    Scene scene = balls(4);
    const ChangeLog::Mark begin = scene.changes.now();
    scene.set_position(SceneBodyId{2}, {1, 0, 0});
    scene.set_group(SceneBodyId{3}, 7);
    ASSERT_TRUE(scene.changes.reaches(begin));
    const auto since = scene.changes.since(begin);
    ASSERT_EQ(since.size(), 2u);
    EXPECT_EQ(since[0].body, 2u);
    EXPECT_TRUE(since[0].only_pose);
    EXPECT_EQ(since[1].body, 3u);
    EXPECT_FALSE(since[1].only_pose);
    scene.set_position(SceneBodyId{2}, {1, 0, 0});
    EXPECT_EQ(scene.changes.since(begin).size(), 2u) << "it exists already";
    EXPECT_TRUE(scene.changes.since(scene.changes.now()).empty());
}

TEST(ChangeLog, ForgetsWhatIsLongAgoAndKnowsIt)
{
    Scene scene = balls(4);
    const ChangeLog::Mark begin = scene.changes.now();
    ChangeLog::Mark last = begin;
    for (int k = 1; k < 10'000; ++k) {
        scene.set_position(SceneBodyId{0}, {double(k), 0, 0});
        ASSERT_TRUE(scene.changes.reaches(last)) << k;
        ASSERT_EQ(scene.changes.since(last).size(), 1u) << k;
        last = scene.changes.now();
    }
    EXPECT_FALSE(scene.changes.reaches(begin));
}

TEST(ChangeLog, IsNotThatOfACopy)
{
    Scene scene = balls(2);
    const ChangeLog::Mark mark = scene.changes.now();
    Scene copy = scene;
    EXPECT_FALSE(copy.changes.reaches(mark));
    EXPECT_TRUE(scene.changes.reaches(mark));
    const Scene moved = std::move(scene);
    EXPECT_TRUE(moved.changes.reaches(mark));
    copy = moved;
    EXPECT_FALSE(copy.changes.reaches(mark));
}

} // namespace
} // namespace oncollide
