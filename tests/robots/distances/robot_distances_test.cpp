// Robot::distances() against every pair measured alone by the World.
#include <gtest/gtest.h>

#include <map>

#include "robots/distances/pair_key.hpp"
#include "robots/long_arm.hpp"
#include "robots/small_robot.hpp"
#include "scenes/test_files.hpp"

namespace oncollide::robot_distances_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using test::add_bodies, test::add_posts, test::Key, test::key_of, test::expect_error, test::long_arm, test::numbers_of,
    test::random_numbers, test::SmallRobot;

/// A robot, and its parts as models.
struct Parts {
    World& world;
    const RobotDescription description;
    const Robot robot;
    std::vector<std::uint32_t> links;
    std::vector<ModelId> models;
    std::vector<Isometry3d> at;

    Parts(World& in, RobotDescription given, const Isometry3d& base)
        : world(in), description(std::move(given)), robot(world, description, base)
    {
        for (std::uint32_t link = 0; link < description.links.size(); ++link)
            for (const LinkGeometry& collision : description.links[link].collision) {
                links.push_back(link), at.push_back(collision.pose);
                models.push_back(world.models().add(collision.geometry));
            }
    }

    /// The least distance of each pair, measured without bounds and orders.
    std::map<Key, Distance> all(std::span<const double> numbers) const
    {
        std::vector<Isometry3d> poses(description.links.size());
        robot.link_poses(numbers, poses);
        std::map<Key, Distance> least;
        const auto take = [&](const Key& key, const Distance& d) {
            const auto [known, is_new] = least.try_emplace(key, d);
            if (!is_new && d.upper < known->second.upper) known->second = d;
        };
        for (std::size_t i = 0; i < models.size(); ++i) {
            const PlacedModel part{models[i], poses[links[i]] * at[i]};
            for (std::size_t k = 0; k < i; ++k) {
                const auto pair = std::minmax(links[i], links[k]);
                if (pair.first == pair.second ||
                    std::ranges::count(description.excluded, std::pair(pair.first, pair.second)))
                    continue;
                take(pair, world.pairs().distance(PlacedModel{models[k], poses[links[k]] * at[k]}, part));
            }
            for (std::uint32_t slot = 0; slot < world.bodies().size(); ++slot)
                take({links[i], 1000 + slot}, world.pairs().distance(part, world.bodies().at(slot)));
        }
        return least;
    }
};

void expect_same(const RobotDistance& d, const Distance& alone, const std::string& of)
{
    ASSERT_LE(d.lower, d.upper) << of;
    if (alone.lower > 0) {
        EXPECT_NEAR(d.upper, alone.upper, 1e-12) << of;
        EXPECT_NEAR(d.lower, alone.lower, 1e-12) << of;
        EXPECT_NEAR((d.other_point - d.point).norm(), d.upper, 1e-9) << of;
        EXPECT_NEAR(d.normal.dot(d.other_point - d.point), d.upper, 1e-9) << of;
    } else {
        EXPECT_LE(d.lower, 0) << of;
        EXPECT_LE(d.upper, alone.upper) << of;
        EXPECT_FALSE(d.unique) << of;
    }
    if (d.normal != Vector3d::Zero()) {
        EXPECT_NEAR(d.normal.norm(), 1, 1e-12) << of;
    }
}

TEST(RobotDistances, AreThoseOfEveryPairMeasuredAlone)
{
    for (const auto& [bodies, reach] : {std::pair<std::size_t, double>{12, 1.3}, {40, 3.5}}) {
        World world;
        add_bodies(world, bodies, reach, bodies);
        const Parts parts(world, long_arm(), random_pose(3, 0.2));
        constexpr std::size_t count = 40;
        const std::vector<double> numbers = numbers_of(parts.robot, count, 0.3);
        RobotDistances least, near, all;
        parts.robot.distances(world, numbers, least);
        parts.robot.distances(world, numbers, near, {.cutoff = 0.2, .every_pair = true});
        parts.robot.distances(world, numbers, all, {.every_pair = true, .gradients = false});
        ASSERT_EQ(least.offsets.size(), count + 1);
        ASSERT_EQ(least.pairs.size(), count);
        EXPECT_EQ(least.gradients.size(), count * parts.robot.width());
        EXPECT_TRUE(all.gradients.empty());
        std::size_t meeting = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const std::string of = "configuration " + std::to_string(i);
            const std::map<Key, Distance> alone =
                parts.all(std::span(numbers).subspan(i * parts.robot.width(), parts.robot.width()));
            ASSERT_EQ(all.offsets[i + 1] - all.offsets[i], alone.size()) << of;
            std::size_t within = 0;
            double nearest = std::numeric_limits<double>::infinity();
            for (const auto& [key, d] : alone) within += d.upper <= 0.2, nearest = std::min(nearest, d.upper);
            EXPECT_EQ(near.offsets[i + 1] - near.offsets[i], within) << of;
            for (std::size_t k = all.offsets[i]; k < all.offsets[i + 1]; ++k) {
                expect_same(all.pairs[k], alone.at(key_of(all.pairs[k])), of);
                if (k > all.offsets[i]) {
                    EXPECT_LE(all.pairs[k - 1].upper, all.pairs[k].upper) << of;
                }
            }
            const RobotDistance& first = least.pairs[i];
            expect_same(first, alone.at(key_of(first)), of);
            EXPECT_EQ(first.upper, all.pairs[all.offsets[i]].upper) << of;
            if (nearest > 0) {
                EXPECT_NEAR(first.upper, nearest, 1e-12) << of;
            }
            meeting += first.upper <= 0;
        }
        EXPECT_GT(meeting, 2u);
        EXPECT_LT(meeting, count - 2);
    }
}

/// The depth of the least of a configuration is the deepest manifold's of its pairs.
TEST(RobotDistances, OfPairsThatMeetAreTheDepthsOfTheirManifolds)
{
    World world;
    add_bodies(world, 30, 1.3, 5);
    const Parts parts(world, long_arm(), random_pose(3, 0.2));
    constexpr std::size_t count = 60;
    const std::vector<double> numbers = numbers_of(parts.robot, count, 1);
    RobotDistances all;
    parts.robot.distances(world, numbers, all, {.cutoff = 0, .every_pair = true});
    std::vector<Isometry3d> poses(parts.description.links.size());
    std::size_t compared = 0;
    for (std::size_t i = 0; i < count; ++i) {
        parts.robot.link_poses(std::span(numbers).subspan(i * parts.robot.width(), parts.robot.width()), poses);
        for (std::size_t k = all.offsets[i]; k < all.offsets[i + 1]; ++k) {
            const RobotDistance& d = all.pairs[k];
            if (d.other != RobotFinding::no_link || std::ranges::count(parts.links, d.link) != 1) continue;
            const auto part = static_cast<std::size_t>(std::ranges::find(parts.links, d.link) - parts.links.begin());
            const Manifold m =
                world.pairs().manifold(PlacedModel{parts.models[part], poses[d.link] * parts.at[part]}, d.body);
            ASSERT_FALSE(m.regions.empty());
            ++compared;
            EXPECT_EQ(d.upper, -m.regions[0].depth_lower);
            EXPECT_LE(d.lower, -m.regions[0].depth_upper);
            EXPECT_EQ(d.normal, m.regions[0].normal);
        }
    }
    EXPECT_GT(compared, 20u);
}

TEST(RobotDistances, AmongHundredsOfBodiesAreTheSame)
{
    World world;
    add_bodies(world, 400, 6, 9);
    for (const double away : {0.0, 50.0}) { // far from all bodies, too
        Isometry3d base = random_pose(3, 0.2);
        base.translation().x() += away;
        const Parts parts(world, long_arm(), base);
        const std::vector<double> numbers = numbers_of(parts.robot, 10, 0.3);
        RobotDistances least, all;
        for (const bool self : {true, false}) {
            parts.robot.distances(world, numbers, least, {.pairs = {.self = self}});
            parts.robot.distances(world, numbers, all, {.pairs = {.self = self}, .every_pair = true});
            ASSERT_EQ(least.pairs.size(), 10u);
            for (std::size_t i = 0; i < 10; ++i) {
                double nearest = std::numeric_limits<double>::infinity();
                std::size_t count = 0;
                for (const auto& [key, d] :
                     parts.all(std::span(numbers).subspan(i * parts.robot.width(), parts.robot.width())))
                    if (self || key.second >= 1000) nearest = std::min(nearest, d.upper), ++count;
                EXPECT_NEAR(std::max(least.pairs[i].upper, 0.0), nearest, 1e-12);
                ASSERT_EQ(all.offsets[i + 1] - all.offsets[i], count) << "without a cutoff, all pairs";
                const RobotDistance &first = all.pairs[all.offsets[i]], &second = all.pairs[all.offsets[i] + 1];
                EXPECT_EQ(least.pairs[i].unique, first.unique && second.lower > first.upper) << i;
            }
        }
    }
}

void expect_equal(const RobotDistances& a, const RobotDistances& b)
{
    EXPECT_EQ(a.offsets, b.offsets);
    EXPECT_EQ(a.gradients, b.gradients);
    ASSERT_EQ(a.pairs.size(), b.pairs.size());
    for (std::size_t i = 0; i < a.pairs.size(); ++i) {
        const RobotDistance &p = a.pairs[i], &q = b.pairs[i];
        const auto numbers = [](const RobotDistance& d) {
            return std::tuple(d.lower, d.upper, d.link, d.other, d.body.slot, d.unique);
        };
        ASSERT_EQ(numbers(p), numbers(q)) << i;
        ASSERT_EQ(p.point, q.point) << i;
        ASSERT_EQ(p.other_point, q.other_point) << i;
        ASSERT_EQ(p.normal, q.normal) << i;
    }
}

TEST(RobotDistances, HaveTheSameBitsForAnyNumberOfThreadsAndAlone)
{
    RobotDistances one, two, alone, joined;
    for (const int threads : {1, 3}) {
        World world({.threads = threads});
        add_bodies(world, 20, 1.3, 5);
        const Robot robot(world, long_arm(), random_pose(3, 0.2));
        const std::vector<double> numbers = numbers_of(robot, 100, 0.2);
        robot.distances(world, numbers, threads == 1 ? one : two, {.every_pair = true});
        if (threads > 1) break;
        RobotDistances least;
        robot.distances(world, numbers, least);
        joined.offsets.push_back(0);
        for (std::size_t i = 0; i < 100; ++i) {
            robot.distances(world, std::span(numbers).subspan(i * robot.width(), robot.width()), alone);
            joined.pairs.insert(joined.pairs.end(), alone.pairs.begin(), alone.pairs.end());
            joined.gradients.insert(joined.gradients.end(), alone.gradients.begin(), alone.gradients.end());
            joined.offsets.push_back(joined.pairs.size());
        }
        expect_equal(least, joined);
    }
    expect_equal(one, two);
}

TEST(RobotDistances, HonourWhatIsTested)
{
    World world;
    const std::vector<BodyId> posts = add_posts(world);
    SmallRobot files;
    Robot robot(world, load_robot(files.urdf, {.srdf = files.srdf, .packages = {{"robot", files.folder().path()}}}));
    const std::vector<double> numbers = random_numbers(5);
    RobotDistances found;
    robot.distances(world, numbers, found, {.pairs = {.environment = false}, .every_pair = true});
    for (const RobotDistance& d : found.pairs) EXPECT_NE(d.other, RobotFinding::no_link);
    const std::size_t self = found.pairs.size();
    robot.distances(world, numbers, found, {.pairs = {.self = false}, .every_pair = true});
    EXPECT_GT(self, 0u);
    EXPECT_EQ(found.pairs.size(), 5 * 5 * posts.size()); // five links have geometry
    world.bodies().set_filter(posts[0], {.layer = 4, .mask = ~0u});
    robot.distances(world, numbers, found, {.pairs = {.self = false, .filter = {.mask = ~4u}}, .every_pair = true});
    EXPECT_EQ(found.pairs.size(), 5 * 5 * (posts.size() - 1));
    robot.add_bodies(world); // its own bodies do not count
    robot.distances(world, numbers, found, {.pairs = {.self = false}, .every_pair = true});
    EXPECT_EQ(found.pairs.size(), 5 * 5 * posts.size());
    robot.distances(world, numbers, found, {.cutoff = 0});
    EXPECT_EQ(found.offsets.size(), 6u);
    robot.distances(world, {}, found);
    EXPECT_EQ(found.offsets, std::vector<std::size_t>{0});
}

TEST(RobotDistances, RefuseWhatMakesNoSense)
{
    World world, other;
    SmallRobot files;
    const Robot robot(world,
                      load_robot(files.urdf, {.srdf = files.srdf, .packages = {{"robot", files.folder().path()}}}));
    RobotDistances found;
    const std::vector<double> numbers = random_numbers(2);
    const auto usage = [](auto action, const char* part) { expect_error(ErrorKind::usage, action, part); };
    usage([&] { robot.distances(other, numbers, found); }, "not the one");
    usage([&] { robot.distances(world, std::span(numbers).first(5), found); }, "5 numbers");
    usage([&] { robot.distances(world, numbers, found, {.tolerance = -1}); }, "tolerance of -1");
    usage([&] { robot.distances(world, numbers, found, {.cutoff = std::nan("")}); }, "cutoff of nan");
    std::vector<double> broken = numbers;
    broken[4] = std::nan("");
    expect_error(
        ErrorKind::bad_data, [&] { robot.distances(world, broken, found); }, "configuration 1");
    std::vector<double> rows(18);
    usage([&] { robot.jacobian(std::span(numbers).first(3), 99, Vector3d::Zero(), rows); }, "no link 99");
    usage([&] { robot.jacobian(std::span(numbers).first(3), 1, Vector3d::Zero(), std::span(rows).first(3)); },
          "are 18");
}

} // namespace
} // namespace oncollide::robot_distances_test
