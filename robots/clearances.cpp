#include <oncollide/robots/clearances.hpp>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace oncollide {

Clearances::Clearances(const Robot::Impl& robot, double of_world)
    : of_world_(of_world), self_(std::max(of_world, robot.padding.self)), most_of_links_(self_), most_of_bodies_(0),
      of_link_(robot.description.links.size(), std::max(of_world, robot.padding.environment))
{
    const RobotPadding& padding = robot.padding;
    for (const RobotPadding::OfLink& each : padding.links) of_link_[each.link] = std::max(of_world, each.clearance);
    for (const double clearance : of_link_) most_of_bodies_ = std::max(most_of_bodies_, clearance);
    for (const auto& [body, clearance, link] : padding.bodies) {
        bodies_.push_back({body, link, std::max(of_world, clearance)});
        most_of_bodies_ = std::max(most_of_bodies_, bodies_.back().clearance);
    }
    for (const auto& [a, b, clearance] : padding.pairs) {
        pairs_.push_back({std::min(a, b), std::max(a, b), std::max(of_world, clearance)});
        most_of_links_ = std::max(most_of_links_, pairs_.back().clearance);
    }
    // The last of several entries for a pair counts.
    std::ranges::stable_sort(bodies_, {}, [](const OfBody& each) { return std::pair(each.body, each.link); });
    std::ranges::stable_sort(pairs_, {}, [](const OfPair& each) { return std::pair(each.a, each.b); });
}

double Clearances::of_links(std::uint32_t a, std::uint32_t b) const
{
    if (pairs_.empty()) return self_;
    const std::pair<std::uint32_t, std::uint32_t> links = std::minmax(a, b);
    const auto own =
        std::ranges::equal_range(pairs_, links, {}, [](const OfPair& each) { return std::pair(each.a, each.b); });
    return own.empty() ? self_ : own.back().clearance;
}

double Clearances::of_body(std::uint32_t link, BodyId body) const
{
    if (bodies_.empty()) return of_link_[link];
    for (const std::uint32_t of : {link, RobotFinding::no_link}) {
        const auto own = std::ranges::equal_range(bodies_, std::pair(body, of), {},
                                                  [](const OfBody& each) { return std::pair(each.body, each.link); });
        if (!own.empty()) return own.back().clearance;
    }
    return of_link_[link];
}

void Robot::Impl::check_link(const char* call, std::uint32_t link) const
{
    if (link >= description.links.size())
        throw Error(ErrorKind::usage, fmt::format("robot: {}: there is no link {}; the robot has {}", call, link,
                                                  description.links.size()));
}

void Robot::set_padding(const RobotPadding& padding)
{
    Impl& p = *impl_;
    const auto check = [&](double clearance) {
        if (!(clearance >= 0 && clearance <= 1e6))
            throw Error(ErrorKind::usage,
                        fmt::format("robot: set_padding: a clearance of {}; must be 0 to 1e6 m", clearance));
    };
    check(padding.environment), check(padding.self);
    for (const RobotPadding::OfLink& each : padding.links)
        p.check_link("set_padding", each.link), check(each.clearance);
    for (const RobotPadding::OfBody& each : padding.bodies) {
        if (each.link != RobotFinding::no_link) p.check_link("set_padding", each.link);
        check(each.clearance);
    }
    for (const RobotPadding::OfPair& each : padding.pairs)
        p.check_link("set_padding", each.a), p.check_link("set_padding", each.b), check(each.clearance);
    p.padding = padding;
    p.idle = Impl::no_checkers(), p.cells.reset(); // they hold clearances
}

const RobotPadding& Robot::padding() const
{
    return impl_->padding;
}

void Robot::set_allowed(std::span<const AllowedContact> allowed)
{
    Impl& p = *impl_;
    p.refuse_with_bodies("set_allowed");
    for (const AllowedContact& each : allowed) {
        p.check_link("set_allowed", each.link);
        if (each.other != RobotFinding::no_link) p.check_link("set_allowed", each.other);
    }
    p.allowed_links.clear(), p.allowed_bodies.clear();
    for (const auto& [link, other, body] : allowed)
        if (other == RobotFinding::no_link)
            p.allowed_bodies.emplace_back(link, body);
        else
            p.allowed_links.push_back(std::minmax(link, other));
    std::ranges::sort(p.allowed_links), std::ranges::sort(p.allowed_bodies);
    p.take_in_groups();
}

} // namespace oncollide
