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
    command.add_option(
        "--padding-file FILE", options.file,
        "clearances per link, body and pair, and allowed contacts, in YAML (docs/robots.md); the options "
        "above replace its values");
}

std::optional<std::uint32_t> PaddingNames::link(const std::string& name) const
{
    const std::vector<RobotLink>& links = robot.description().links;
    const auto found = std::ranges::find(links, name, &RobotLink::name);
    if (found == links.end()) return {};
    return static_cast<std::uint32_t>(found - links.begin());
}

std::optional<BodyId> PaddingNames::body(const std::string& name) const
{
    const auto found = environment.scene.find(name);
    if (!found) return {};
    return environment.pipeline.body(*found);
}

namespace {

std::string no_such_name(const PaddingNames& names, const std::string& name, bool bodies)
{
    std::vector<std::string_view> known;
    for (const RobotLink& link : names.robot.description().links) known.push_back(link.name);
    const Scene& scene = names.environment.scene;
    for (std::uint32_t body = 0; bodies && body < scene.size(); ++body)
        if (const std::string_view own = scene.names[body]; !own.empty()) known.push_back(own);
    return fmt::format("no link{} '{}'{}", bodies ? " or body" : "", printable(name),
                       printable(valid_names(name, known)));
}

/// Both sides of NAME=VALUE.
std::pair<std::string, std::string> sides_of(const char* option, const std::string& text, const char* form)
{
    const std::size_t at = text.find('=');
    if (at == 0 || at >= text.size() - 1) usage(fmt::format("{} {}: expected {}", option, printable(text), form));
    return {text.substr(0, at), text.substr(at + 1)};
}

} // namespace

std::string PaddingNames::no_link(const std::string& name) const
{
    return no_such_name(*this, name, false);
}

std::string PaddingNames::no_link_or_body(const std::string& name) const
{
    return no_such_name(*this, name, true);
}

void set_padding(const PaddingOptions& options, const RobotWorld& environment, Robot& robot)
{
    const PaddingNames names{robot, environment};
    const auto link_of = [&](const char* option, const std::string& name) {
        const auto link = names.link(name);
        if (!link) usage(fmt::format("{}: {}", option, names.no_link(name)));
        return *link;
    };
    auto [padding, allowed] = options.file.empty() ? PaddingRules{} : read_padding_file(options.file, names);
    for (const auto& [option, value, into] : {std::tuple("--padding", options.environment, &padding.environment),
                                              {"--self-padding", options.self, &padding.self}}) {
        if (!value) continue;
        if (!(*value >= 0 && *value <= 1e6)) usage(fmt::format("{} {}: must be 0 to 1e6 m", option, *value));
        *into = *value;
    }
    for (const std::string& text : options.links) {
        const auto [name, length] = sides_of("--link-padding", text, "LINK=LENGTH");
        const std::uint32_t link = link_of("--link-padding", name);
        std::erase_if(padding.links, [&](const RobotPadding::OfLink& each) { return each.link == link; });
        padding.links.push_back({link, length_from("--link-padding", length, unit_from("", "m"))});
    }
    robot.set_padding(padding);
    for (const std::string& text : options.allowed) {
        const auto [link, other] = sides_of("--allow", text, "LINK=LINK or LINK=BODY");
        const std::uint32_t first = link_of("--allow", link);
        if (const auto body = names.body(other))
            allowed.push_back({.link = first, .body = *body});
        else if (const auto second = names.link(other))
            allowed.push_back({.link = first, .other = *second});
        else
            usage("--allow: " + names.no_link_or_body(other));
    }
    robot.set_allowed(allowed);
}

} // namespace oncollide::tools
