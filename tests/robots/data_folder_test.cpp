// Real robots, of the data folder.
#include <gtest/gtest.h>

#include <random>

#include "scenes/test_files.hpp"
#include <oncollide/robots/robot.hpp>
#include <oncollide/robots/spheres/sphere_judge.hpp>
#include <oncollide/robots/spheres/sphere_maker.hpp>

namespace oncollide::robot_data_test {
namespace {

class RobotDataFolder : public ::testing::Test {
protected:
    void SetUp() override
    {
        folder_ = test::data_folder();
        if (folder_.empty() || !std::filesystem::exists(folder_ / "robots"))
            GTEST_SKIP() << "the data folder has no robots";
        folder_ /= "robots";
    }
    RobotDescription load(const std::string& name) const
    {
        return load_robot(folder_ / name / (name + ".urdf"), {.srdf = folder_ / name / (name + ".srdf")});
    }
    std::filesystem::path folder_;
};

TEST_F(RobotDataFolder, StatesOfThePandaAndTheUr5AreFree)
{
    for (const auto& [name, state, width] : {std::tuple{"panda", "ready", 7u}, {"ur5", "home", 6u}}) {
        World world;
        const Robot robot(world, load(name));
        EXPECT_EQ(robot.width(), width);
        std::vector<double> q = robot.neutral();
        robot.apply_state(state, "", q);
        robot.check_configuration(q, true);
        std::vector<RobotFinding> found(1);
        robot.check(world, q, found);
        EXPECT_EQ(found[0].verdict, Verdict::separate) << name;
    }
}

/// Every pair of links that is not excluded, without bounding spheres, batches or early stops.
TEST_F(RobotDataFolder, RandomConfigurationsAreDecidedAsPairByPair)
{
    for (const char* name : {"panda", "ur5"}) {
        World world;
        const RobotDescription description = load(name);
        const Robot robot(world, description);
        World pairs;
        std::vector<std::vector<std::pair<ModelId, Eigen::Isometry3d>>> parts(description.links.size());
        for (std::size_t i = 0; i < parts.size(); ++i)
            for (const LinkGeometry& collision : description.links[i].collision)
                parts[i].push_back({pairs.models().add(collision.geometry), collision.pose});
        constexpr std::size_t count = 200;
        std::mt19937 random(4);
        std::vector<double> numbers;
        for (std::size_t i = 0; i < count * robot.width(); ++i)
            numbers.push_back(std::uniform_real_distribution(-2.8, 2.8)(random));
        std::vector<RobotFinding> found(count);
        robot.check(world, numbers, found);
        std::size_t colliding = 0;
        std::vector<Eigen::Isometry3d> poses(parts.size());
        for (std::size_t k = 0; k < count; ++k) {
            robot.link_poses(std::span(numbers).subspan(k * robot.width(), robot.width()), poses);
            bool hit = false;
            for (std::uint32_t b = 0; b < parts.size(); ++b)
                for (std::uint32_t a = 0; a < b; ++a) {
                    if (std::ranges::count(description.excluded, std::pair(a, b))) continue;
                    for (const auto& [model_a, pose_a] : parts[a])
                        for (const auto& [model_b, pose_b] : parts[b])
                            hit = hit || pairs.pairs()
                                                 .decide(PlacedModel{model_a, poses[a] * pose_a},
                                                         PlacedModel{model_b, poses[b] * pose_b})
                                                 .verdict == Verdict::colliding;
                }
            EXPECT_EQ(found[k].verdict == Verdict::colliding, hit) << name << " " << k;
            colliding += hit;
        }
        EXPECT_GT(colliding, 10u);
        EXPECT_LT(colliding, count - 10);
    }
}

TEST_F(RobotDataFolder, ThePublishedSpheresLeaveHalfOfThePandaUncovered)
{
    const RobotDescription panda = load("panda"), spheres = load_robot(folder_ / "panda" / "panda_spherized.urdf");
    double area = 0, least = 0, most = 0, gap = 0;
    for (std::size_t i = 0; i < panda.links.size(); ++i) {
        const LinkSurface surface(panda.links[i]);
        if (surface.triangles().empty()) continue;
        std::vector<CoverSphere> model;
        const auto link = std::ranges::find(spheres.links, panda.links[i].name, &RobotLink::name);
        ASSERT_NE(link, spheres.links.end());
        for (const LinkGeometry& sphere : link->collision)
            model.push_back(
                {sphere.pose.translation(), std::get<Sphere>(std::get<Shape>(sphere.geometry->data)).radius});
        const CoverJudgement judged = judge_cover(surface, model);
        area += judged.area, least += judged.uncovered, most += judged.uncovered_most;
        gap = std::max(gap, judged.gap);
        const CoverJudgement own = judge_cover(surface, SphereMaker(surface).within(0.03));
        EXPECT_TRUE(own.complete) << panda.links[i].name;
        EXPECT_LE(own.over_reach, 0.03) << panda.links[i].name;
    }
    EXPECT_GT(least / area, 0.49);
    EXPECT_LT(most / area, 0.5);
    EXPECT_NEAR(gap, 0.0825, 1e-4);
}

} // namespace
} // namespace oncollide::robot_data_test
