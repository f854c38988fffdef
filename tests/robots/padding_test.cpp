// Padding and allowed contacts: Robot::check() and check_edges() against the distances of all pairs.
#include <gtest/gtest.h>

#include "robots/long_arm.hpp"
#include "robots/small_robot.hpp"
#include "scenes/test_files.hpp"

namespace oncollide::robot_padding_test {
namespace {

using Eigen::Isometry3d;
using test::add_bodies, test::add_posts, test::expect_error, test::long_arm, test::numbers_of, test::random_numbers,
    test::SmallRobot;

constexpr std::uint32_t no_link = RobotFinding::no_link;

/// The clearance of a pair, as RobotPadding documents it.
double clearance_of(const RobotPadding& padding, const RobotDistance& d)
{
    double clearance = d.other == no_link ? padding.environment : padding.self;
    if (d.other == no_link) {
        for (const auto& each : padding.links)
            if (each.link == d.link) clearance = each.clearance;
        for (const auto& each : padding.bodies)
            if (each.body == d.body && each.link == no_link) clearance = each.clearance;
        for (const auto& each : padding.bodies)
            if (each.body == d.body && each.link == d.link) clearance = each.clearance;
    } else {
        for (const auto& each : padding.pairs)
            if (std::minmax(each.a, each.b) == std::minmax(d.link, d.other)) clearance = each.clearance;
    }
    return clearance;
}

/// True if some pair is closer than its clearance; `sure` is false where rounding may decide.
bool is_refused(const Robot& robot, const RobotDistances& all, std::size_t i, bool& sure)
{
    bool refused = false;
    sure = true;
    for (std::size_t k = all.offsets[i]; k < all.offsets[i + 1]; ++k) {
        const double clearance = clearance_of(robot.padding(), all.pairs[k]);
        refused |= all.pairs[k].upper <= clearance;
        if (std::abs(all.pairs[k].upper - clearance) < 1e-9) sure = false;
    }
    return refused;
}

RobotPadding padding_of(int kind, std::span<const BodyId> bodies)
{
    switch (kind) {
    case 0:
        return {.environment = 0.05};
    case 1:
        return {.self = 0.03};
    case 2:
        return {.environment = 0.02, .self = 0.01, .links = {{5, 0.15}, {3, 0}}, .pairs = {{0, 3, 0.2}, {5, 2, 0}}};
    default:
        return {.environment = 0.01,
                .links = {{4, 0.03}},
                .bodies = {{bodies[0], 0.3}, {bodies[1], 0, 5}, {bodies[2], 0.2, 4}, {bodies[2], 0.02}}};
    }
}

TEST(RobotPadding, RefusesPairsThatAreCloserThanTheirClearance)
{
    for (int kind = 0; kind < 4; ++kind) {
        World world;
        add_bodies(world, 12, 1.8, 12);
        std::vector<BodyId> bodies;
        for (std::uint32_t slot = 0; slot < world.bodies().size(); ++slot) bodies.push_back(world.bodies().at(slot));
        Robot robot(world, long_arm(), random_pose(3, 0.2));
        constexpr std::size_t count = 200;
        const std::vector<double> numbers = numbers_of(robot, count, 0.3);
        std::vector<RobotFinding> plain(count), padded(count);
        robot.check(world, numbers, plain);
        robot.set_padding(padding_of(kind, bodies));
        robot.check(world, numbers, padded);
        RobotDistances all;
        robot.distances(world, numbers, all, {.cutoff = 0.4, .every_pair = true, .gradients = false, .depths = false});
        std::size_t within = 0;
        for (std::size_t i = 0; i < count; ++i) {
            bool sure;
            const bool refused = is_refused(robot, all, i, sure);
            EXPECT_TRUE(!sure || (padded[i].verdict != Verdict::separate) == refused) << kind << " " << i;
            EXPECT_TRUE(plain[i].verdict != Verdict::colliding || padded[i].verdict != Verdict::separate);
            within += padded[i].verdict == Verdict::within;
            if (padded[i].verdict != Verdict::within) continue;
            const auto own = std::span(all.pairs).subspan(all.offsets[i], all.offsets[i + 1] - all.offsets[i]);
            const auto pair = std::ranges::find_if(own, [&](const RobotDistance& d) {
                return d.other == padded[i].other &&
                       (d.other == no_link
                            ? d.link == padded[i].link && d.body == padded[i].body
                            : std::minmax(d.link, d.other) == std::minmax(padded[i].link, padded[i].other));
            });
            ASSERT_TRUE(pair != own.end()) << kind << " " << i;
            EXPECT_EQ(padded[i].bound, clearance_of(robot.padding(), *pair));
            EXPECT_LE(pair->lower, padded[i].bound);
        }
        EXPECT_GT(within, 3u) << kind;
        robot.set_padding({});
        robot.check(world, numbers, padded);
        for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(padded[i].verdict, plain[i].verdict);
    }
}

TEST(RobotPadding, CertifiedEdgesKeepTheirClearance)
{
    for (int kind = 0; kind < 4; ++kind) {
        World world;
        add_bodies(world, 12, 1.8, 12);
        std::vector<BodyId> bodies;
        for (std::uint32_t slot = 0; slot < world.bodies().size(); ++slot) bodies.push_back(world.bodies().at(slot));
        Robot robot(world, long_arm(), random_pose(3, 0.2));
        robot.set_padding(padding_of(kind, bodies));
        constexpr std::size_t count = 40, samples = 100;
        const std::vector<double> numbers = numbers_of(robot, 2 * count, 0.3);
        const std::size_t half = count * robot.width();
        std::vector<RobotEdgeFinding> found(count);
        robot.check_edges(world, std::span(numbers).first(half), std::span(numbers).subspan(half), found,
                          {.tolerance = 1e-3});
        std::size_t contacts = 0, clear = 0;
        std::vector<RobotFinding> at(samples + 1);
        for (std::size_t i = 0; i < count; ++i) {
            std::vector<double> way;
            for (std::size_t k = 0; k <= samples; ++k)
                for (std::size_t n = 0; n < robot.width(); ++n)
                    way.push_back(std::lerp(numbers[i * robot.width() + n], numbers[half + i * robot.width() + n],
                                            double(k) / samples));
            robot.check(world, way, at);
            for (std::size_t k = 0; k <= samples; ++k)
                EXPECT_TRUE(double(k) / samples >= found[i].clear_until || at[k].verdict == Verdict::separate)
                    << kind << " " << i << " " << k;
            contacts += found[i].contact_by > 0 && found[i].contact_by <= 1, clear += found[i].clear_until > 0.5;
        }
        EXPECT_GT(contacts, 2u) << kind;
        EXPECT_GT(clear, 2u) << kind;
    }
}

TEST(RobotPadding, AllowedContactsAreNotTested)
{
    World world;
    const std::vector<BodyId> posts = add_posts(world);
    SmallRobot files;
    Robot robot(world, load_robot(files.urdf, {.srdf = files.srdf, .packages = {{"robot", files.folder().path()}}}));
    constexpr std::size_t count = 300;
    const std::vector<double> numbers = random_numbers(count);
    std::vector<RobotFinding> plain(count), allowed(count);
    robot.check(world, numbers, plain, {.self = false});
    std::vector<AllowedContact> all;
    for (std::uint32_t link = 0; link < robot.description().links.size(); ++link)
        all.push_back({.link = link, .body = posts[1]});
    robot.set_allowed(all);
    robot.check(world, numbers, allowed, {.self = false});
    std::size_t with_it = 0;
    for (std::size_t i = 0; i < count; ++i) {
        EXPECT_NE(allowed[i].body, posts[1]);
        with_it += plain[i].body == posts[1] && plain[i].verdict == Verdict::colliding;
        EXPECT_TRUE(plain[i].verdict != Verdict::separate || allowed[i].verdict == Verdict::separate);
    }
    EXPECT_GT(with_it, 3u);
    RobotDistances found;
    robot.distances(world, numbers, found, {.every_pair = true});
    for (const RobotDistance& d : found.pairs) EXPECT_NE(d.body, posts[1]);
    std::vector<RobotEdgeFinding> edges(count / 2);
    robot.check_edges(world, std::span(numbers).first(3 * count / 2), std::span(numbers).subspan(3 * count / 2), edges);
    for (const RobotEdgeFinding& edge : edges) EXPECT_NE(edge.body, posts[1]);
    // Two links: the pair of the base and the lower arm is gone.
    robot.set_allowed(std::vector<AllowedContact>{{.link = 2, .other = 0}});
    robot.distances(world, numbers, found, {.pairs = {.environment = false}, .every_pair = true});
    for (const RobotDistance& d : found.pairs) EXPECT_NE(std::pair(d.link, d.other), std::pair(0u, 2u));
    // Bodies of frames do not collide either.
    robot.set_allowed(all);
    robot.add_bodies(world);
    robot.set_joints(world, std::span(numbers).first(3));
    for (const PairResult& pair : world.step().pairs) EXPECT_TRUE(pair.a != posts[1] && pair.b != posts[1]);
    expect_error(
        ErrorKind::usage, [&] { robot.set_allowed({}); }, "remove_bodies");
    robot.remove_bodies(world);
    robot.set_allowed({});
    robot.check(world, numbers, allowed, {.self = false});
    for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(allowed[i].verdict, plain[i].verdict);
}

TEST(RobotPadding, RefusesWhatMakesNoSense)
{
    World world;
    Robot robot(world, long_arm());
    const auto usage = [](auto action, const char* part) { expect_error(ErrorKind::usage, action, part); };
    usage([&] { robot.set_padding({.environment = -1}); }, "clearance of -1");
    usage([&] { robot.set_padding({.self = std::nan("")}); }, "clearance of nan");
    usage([&] { robot.set_padding({.links = {{9, 0.1}}}); }, "no link 9");
    usage([&] { robot.set_padding({.pairs = {{1, 99, 0.1}}}); }, "no link 99");
    usage([&] { robot.set_padding({.bodies = {{{}, 1e7}}}); }, "10000000");
    usage([&] { robot.set_allowed(std::vector<AllowedContact>{{.link = 77}}); }, "no link 77");
    EXPECT_EQ(robot.padding().environment, 0);
}

} // namespace
} // namespace oncollide::robot_padding_test
