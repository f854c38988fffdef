#include "robot/robot_padding.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "cli/lengths.hpp"
#include "cli/options.hpp"
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/text/printable.hpp>

namespace oncollide::tools {

void add_padding_options(Arguments command, PaddingOptions& options)
{
    command
        .add_option("--padding M", options.environment,
                    "clearance of all links: a body that is closer makes a configuration 'within' (default 0)")
        .length();
    command.add_option("--link-padding LINK=M", options.links, "the clearance of one link, instead").repeatable();
    command.add_option("--self-padding M", options.self, "clearance between two links (default 0)").length();
    command
        .add_option("--allow LINK=NAME", options.allowed,
                    "do not test a link and another one, or a body of the environment, by their names")
        .repeatable();
}

namespace {

/// Both sides of NAME=VALUE.
std::pair<std::string, std::string> sides_of(const char* option, const std::string& text, const char* form)
{
    const std::size_t at = text.find('=');
    if (at == 0 || at >= text.size() - 1) usage(fmt::format("{} {}: expected {}", option, printable(text), form));
    return {text.substr(0, at), text.substr(at + 1)};
}

/// @param environment  null: bodies are not valid
std::uint32_t link_of(const char* option, const std::string& name, const Robot& robot,
                      const Scene* environment = nullptr)
{
    const std::vector<RobotLink>& links = robot.description().links;
    const auto found = std::ranges::find(links, name, &RobotLink::name);
    if (found != links.end()) return static_cast<std::uint32_t>(found - links.begin());
    std::vector<std::string_view> known;
    for (const RobotLink& link : links) known.push_back(link.name);
    for (std::uint32_t body = 0; environment && body < environment->size(); ++body)
        if (const std::string_view own = environment->names[body]; !own.empty()) known.push_back(own);
    usage(fmt::format("{}: no link{} '{}'{}", option, environment ? " or body" : "", printable(name),
                      printable(valid_names(name, known))));
}

} // namespace

void set_padding(const PaddingOptions& options, const RobotWorld& environment, Robot& robot)
{
    for (const auto& [option, value] : {std::pair("--padding", options.environment), {"--self-padding", options.self}})
        if (!(value >= 0 && value <= 1e6)) usage(fmt::format("{} {}: must be 0 to 1e6 m", option, value));
    RobotPadding padding{.environment = options.environment, .self = options.self};
    for (const std::string& text : options.links) {
        const auto [link, length] = sides_of("--link-padding", text, "LINK=LENGTH");
        padding.links.push_back(
            {link_of("--link-padding", link, robot), length_from("--link-padding", length, unit_from("", "m"))});
    }
    robot.set_padding(padding);
    std::vector<AllowedContact> allowed;
    for (const std::string& text : options.allowed) {
        const auto [link, other] = sides_of("--allow", text, "LINK=LINK or LINK=BODY");
        const std::uint32_t first = link_of("--allow", link, robot);
        if (const auto body = environment.scene.find(other))
            allowed.push_back({.link = first, .body = environment.pipeline.body(*body)});
        else
            allowed.push_back({.link = first, .other = link_of("--allow", other, robot, &environment.scene)});
    }
    robot.set_allowed(allowed);
}

} // namespace oncollide::tools
