// SRDF: which pairs of links are not tested, groups, and named states.
#include <oncollide/robots/description_fault.hpp>
#include <oncollide/robots/files/robot_reader.hpp>

#include <algorithm>
#include <set>

#include <fmt/format.h>

namespace oncollide {

namespace {

class SrdfReader {
public:
    SrdfReader(const RobotSource& source, RobotDescription& robot)
        : source_(source), robot_(robot), root_(read_xml_elements(source, [](std::string_view, int) { return true; }))
    {
    }

    void read()
    {
        if (root_.name != "robot") source_.fail_at(root_, "is not SRDF, whose outermost element is 'robot'");
        if (source_.required(root_, "name") != robot_.name)
            source_.fail_at(root_, fmt::format("the file is for another robot than {}, the URDF's",
                                               oncollide::quoted(robot_.name)));
        for (const XmlElement& child : root_.children)
            if (child.name == "group") read_group(child);
        for (const XmlElement& child : root_.children)
            if (child.name == "group_state") read_state(child);
        read_excluded();
        check();
    }

private:
    std::uint32_t link(const XmlElement& element, std::string_view key)
    {
        return find_named(source_, element, "link", source_.required(element, key), robot_.links);
    }
    std::uint32_t joint(const XmlElement& element, std::string_view key)
    {
        return find_named(source_, element, "joint", source_.required(element, key), robot_.joints);
    }
    /// The joint above a link; -1: the root.
    int above(std::uint32_t link) const
    {
        const auto found = std::ranges::find(robot_.joints, link, &RobotJoint::child);
        return found == robot_.joints.end() ? -1 : static_cast<int>(found - robot_.joints.begin());
    }

    struct Members {
        std::set<std::uint32_t> links, joints;
    };
    void add_link(Members& members, std::uint32_t link) const
    {
        members.links.insert(link);
        if (const int joint = above(link); joint >= 0) members.joints.insert(static_cast<std::uint32_t>(joint));
    }

    void read_group(const XmlElement& element)
    {
        const std::string& name = source_.required(element, "name");
        if (std::ranges::count(robot_.groups, name, &RobotGroup::name))
            source_.fail_at(element, "there are two groups of this name");
        Members members;
        for (const XmlElement& child : element.children) {
            if (child.name == "link") add_link(members, link(child, "name"));
            if (child.name == "joint" || child.name == "passive_joint") {
                const std::uint32_t i = joint(child, "name");
                members.joints.insert(i), members.links.insert(robot_.joints[i].child);
            }
            if (child.name == "chain") add_chain(members, child);
            if (child.name == "group") {
                const std::string& other = source_.required(child, "name");
                const auto found = std::ranges::find(robot_.groups, other, &RobotGroup::name);
                if (found == robot_.groups.end()) source_.fail_at(child, "there is no group of this name above it");
                members.links.insert(found->links.begin(), found->links.end());
                members.joints.insert(found->joints.begin(), found->joints.end());
            }
        }
        robot_.groups.push_back(
            {name, {members.links.begin(), members.links.end()}, {members.joints.begin(), members.joints.end()}});
    }

    /// The links from the tip up to the base.
    void add_chain(Members& members, const XmlElement& element)
    {
        const std::uint32_t base = link(element, "base_link");
        for (std::uint32_t at = link(element, "tip_link"); at != base;) {
            const int joint = above(at);
            if (joint < 0)
                source_.fail_at(element, fmt::format("its base_link {} is not above its tip_link",
                                                     oncollide::quoted(robot_.links[base].name)));
            add_link(members, at);
            at = robot_.joints[static_cast<std::size_t>(joint)].parent;
        }
        members.links.insert(base);
    }

    void read_state(const XmlElement& element)
    {
        RobotState state{source_.required(element, "name"), source_.required(element, "group"), {}};
        for (const XmlElement& child : element.children) {
            if (child.name != "joint") continue;
            const std::uint32_t i = joint(child, "name");
            const auto count = static_cast<std::size_t>(numbers_of(robot_.joints[i]));
            if (count == 0) continue; // fixed or mimic: it has no value of its own
            source_.required(child, "value");
            state.values.push_back({i, *source_.numbers(child, "value", count)});
        }
        robot_.states.push_back(std::move(state)), states_.push_back(&element);
    }

    void read_excluded()
    {
        std::set<std::pair<std::uint32_t, std::uint32_t>> excluded;
        for (const XmlElement& child : root_.children)
            if (child.name == "disable_default_collisions")
                for (std::uint32_t a = link(child, "link"), b = 0; b < robot_.links.size(); ++b)
                    if (a != b) excluded.insert(std::minmax(a, b));
        for (const XmlElement& child : root_.children) {
            const bool enable = child.name == "enable_collisions";
            if (!enable && child.name != "disable_collisions") continue;
            const std::uint32_t a = link(child, "link1"), b = link(child, "link2");
            if (a == b)
                source_.fail_at(child, fmt::format("names link {} twice", oncollide::quoted(robot_.links[a].name)));
            if (enable)
                excluded.erase(std::minmax(a, b));
            else
                excluded.insert(std::minmax(a, b));
        }
        robot_.excluded.assign(excluded.begin(), excluded.end());
    }

    /// The checks that descriptions from all sources pass.
    void check() const
    {
        const std::optional<DescriptionFault> fault = fault_of(robot_);
        if (!fault) return;
        source_.fail_at(fault->of == DescriptionFault::Of::state ? *states_[fault->number] : root_, fault->what);
    }

    const RobotSource& source_;
    RobotDescription& robot_;
    const XmlElement root_;
    std::vector<const XmlElement*> states_; ///< as in robot_
};

} // namespace

void read_srdf(const RobotSource& source, RobotDescription& robot)
{
    SrdfReader(source, robot).read();
}

} // namespace oncollide
