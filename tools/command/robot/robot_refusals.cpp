#include "robot/robot_refusals.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "cli/log.hpp"
#include "cli/options.hpp"
#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/text/printable.hpp>

namespace oncollide::tools {

void check_pairs(const RobotOptions& options, bool no_self, const RobotDescription& robot, std::size_t bodies)
{
    if (no_self && options.world.empty()) usage("--no-self: needs --world; the robot is compared with nothing");
    std::vector<std::uint32_t> links; // links with collision geometry
    for (std::uint32_t i = 0; i < robot.links.size(); ++i)
        if (!robot.links[i].collision.empty()) links.push_back(i);
    if (links.empty()) refuse(options.urdf, "no link has collision geometry, so the robot is compared with nothing");
    bool tested = bodies > 0;
    for (std::size_t b = 1; b < links.size() && !tested && !no_self; ++b)
        for (std::size_t a = 0; a < b && !tested; ++a)
            tested = !std::ranges::binary_search(robot.excluded, std::pair(links[a], links[b]));
    if (!tested)
        refuse(options.urdf,
               fmt::format("the robot is compared with nothing: {} has no body, and {}",
                           options.world.empty() ? "the environment" : options.world,
                           no_self ? "--no-self leaves out pairs of links" : "all pairs of its links are excluded"));
}

void tell_links_without_geometry(const RobotDescription& robot)
{
    std::vector<std::string> names;
    for (const RobotLink& link : robot.links)
        if (link.collision.empty()) names.push_back(fmt::format("'{}'", shortened(link.name)));
    if (names.empty()) return;
    const std::size_t count = names.size();
    constexpr std::size_t most = 5;
    if (count > most) names.resize(most - 1), names.push_back(fmt::format("{} more", count - names.size()));
    log(LogLevel::note, fmt::format("{} of {} links {} no collision geometry: {}", count, robot.links.size(),
                                    count == 1 ? "has" : "have", listed(names)));
}

LimitsCheck limits_check(const std::string& text)
{
    constexpr std::array<std::string_view, 3> names = {"ignore", "warn", "refuse"};
    const auto found = std::ranges::find(names, text);
    if (found == names.end())
        usage(fmt::format("--limits: unknown value '{}'{}", printable(text),
                          valid_names(text, {names.begin(), names.end()})));
    return static_cast<LimitsCheck>(found - names.begin());
}

void check_limits(LimitsCheck check, const Robot& robot, std::span<const double> numbers, bool quiet)
{
    if (check == LimitsCheck::ignore) return;
    const std::size_t count = robot.width() ? numbers.size() / robot.width() : 1;
    struct Limits {
        const RobotJoint* joint;
        std::size_t number; ///< number of the configuration
    };
    std::vector<Limits> limits;
    for (const RobotJoint& joint : robot.description().joints) {
        const auto found = std::ranges::find(robot.names(), joint.name);
        if (found != robot.names().end())
            limits.push_back({&joint, static_cast<std::size_t>(found - robot.names().begin())});
    }
    std::size_t out = 0;
    std::string first;
    for (std::size_t i = 0; i < count; ++i) {
        const double* const mine = numbers.data() + i * robot.width();
        const auto broken = std::ranges::find_if(limits, [&](const Limits& l) {
            return mine[l.number] < l.joint->lower || mine[l.number] > l.joint->upper;
        });
        if (broken == limits.end()) continue;
        if (++out == 1)
            first = fmt::format("configuration {}: joint '{}': {} is out of its limits, {} to {}", i,
                                shortened(printable(broken->joint->name)), mine[broken->number], broken->joint->lower,
                                broken->joint->upper);
        if (check == LimitsCheck::refuse) throw Error(ErrorKind::bad_data, first);
    }
    if (out && !quiet)
        log(LogLevel::warning, fmt::format("{} of {} configurations {} out of the limits of a joint; the first is {} "
                                           "(--limits refuse: an error)",
                                           out, count, out == 1 ? "is" : "are", first));
}

} // namespace oncollide::tools
