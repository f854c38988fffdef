// URDF: links, joints and their tree.
#include <oncollide/robots/files/robot_reader.hpp>

#include <algorithm>
#include <array>
#include <unordered_map>

#include <fmt/format.h>

#include <oncollide/base/text/file_warning.hpp>
#include <oncollide/base/text/near_word.hpp>

namespace oncollide {

namespace {

constexpr std::array<std::string_view, 6> kinds = {"fixed",     "revolute", "continuous",
                                                   "prismatic", "planar",   "floating"};
/// Children of <robot> that only xacro's files have.
constexpr std::array<std::string_view, 7> xacro_words = {"macro", "property", "include",     "arg",
                                                         "if",    "unless",   "insert_block"};

/// Whether the reader uses an element.
bool keep(std::string_view name, int level)
{
    constexpr std::array<std::string_view, 4> unused = {"visual", "inertial", "material", "gazebo"};
    if (level > 1) return !std::ranges::count(unused, name);
    return name == "link" || name == "joint" || std::ranges::count(xacro_words, name);
}

class UrdfReader {
public:
    UrdfReader(const RobotSource& source, const std::filesystem::path& urdf, const RobotReading& reading)
        : source_(source), root_(read_xml_elements(source, keep)), geometries_(source, urdf, reading)
    {
    }

    RobotDescription read()
    {
        if (root_.name != "robot")
            source_.fail_at(root_, "is neither URDF nor MJCF, whose outermost elements are 'robot' and 'mujoco'");
        robot_.name = source_.required(root_, "name");
        for (const XmlElement& child : root_.children)
            if (child.name != "link" && child.name != "joint")
                source_.fail_at(
                    child, fmt::format("the file is for xacro; expand it first: xacro {} > robot.urdf", source_.name));
        for (const XmlElement& child : root_.children)
            if (child.name == "link") read_link(child);
        for (const XmlElement& child : root_.children)
            if (child.name == "joint") read_joint(child);
        for (std::uint32_t i = 0; i < joints_.size(); ++i) read_mimic(i);
        resolve_mimics();
        source_.check(robot_, links_, joints_, root_);
        return std::move(robot_);
    }

private:
    void read_link(const XmlElement& element)
    {
        RobotLink link{source_.required(element, "name"), {}};
        if (!link_numbers_.emplace(link.name, robot_.links.size()).second)
            source_.fail_at(element, "there are two links of this name");
        for (const XmlElement& child : element.children)
            if (child.name == "collision") link.collision.push_back(geometries_.read(child, link.name));
        links_.push_back(&element);
        robot_.links.push_back(std::move(link));
    }

    std::uint32_t link_at(const XmlElement& joint, const char* which)
    {
        const XmlElement* const element = joint.find(which);
        if (!element) source_.fail_at(joint, fmt::format("has no {} link", which));
        const std::string& name = source_.required(*element, "link");
        const auto found = link_numbers_.find(name);
        return found == link_numbers_.end() ? find_named(source_, joint, "link", name, robot_.links) : found->second;
    }

    void read_joint(const XmlElement& element)
    {
        RobotJoint joint;
        joint.name = source_.required(element, "name");
        if (!joint_numbers_.emplace(joint.name, robot_.joints.size()).second)
            source_.fail_at(element, "there are two joints of this name");
        const std::string& kind = source_.required(element, "type");
        const auto found = std::ranges::find(kinds, kind);
        if (found == kinds.end())
            source_.fail_at(element,
                            "unknown type " + oncollide::quoted(kind) + valid_names("", {kinds.begin(), kinds.end()}));
        joint.kind = static_cast<JointKind>(found - kinds.begin());
        joint.parent = link_at(element, "parent"), joint.child = link_at(element, "child");
        joint.origin = origin_of(source_, element);
        if (const XmlElement* axis = element.find("axis"); axis && joint.kind != JointKind::fixed) {
            const Eigen::Vector3d along = source_.vector(*axis, "xyz", Eigen::Vector3d::UnitX());
            const double length = along.stableNorm();
            if (joint.kind != JointKind::floating && !(length > 1e-9 && length < 1e9))
                source_.fail_at(element, "its axis has no direction");
            joint.axis = along / length;
        }
        if (joint.kind == JointKind::revolute || joint.kind == JointKind::prismatic) read_limits(element, joint);
        joints_.push_back(&element);
        robot_.joints.push_back(std::move(joint));
    }

    void read_limits(const XmlElement& element, RobotJoint& joint)
    {
        const XmlElement* const limit = element.find("limit");
        if (!limit && element.find("mimic")) // its values come from another joint, which has limits
            return warn_of_file(source_.name, fmt::format("joint {} has no limit; it moves as far as the joint that it "
                                                          "mimics takes it",
                                                          oncollide::quoted(joint.name)));
        if (!limit) source_.fail_at(element, "a " + std::string(name_of(joint.kind)) + " joint needs a limit");
        joint.lower = source_.number(*limit, "lower", 0), joint.upper = source_.number(*limit, "upper", 0);
    }

    void read_mimic(std::uint32_t i)
    {
        const XmlElement* const mimic = joints_[i]->find("mimic");
        if (!mimic) return;
        RobotJoint& joint = robot_.joints[i];
        if (joint.kind == JointKind::fixed) return; // nothing to move
        const std::string& name = source_.required(*mimic, "joint");
        const auto found = joint_numbers_.find(name);
        const std::uint32_t of = found == joint_numbers_.end()
                                     ? find_named(source_, *joints_[i], "joint", name, robot_.joints)
                                     : found->second;
        joint.mimics = static_cast<std::int32_t>(of);
        joint.multiplier = source_.number(*mimic, "multiplier", 1), joint.offset = source_.number(*mimic, "offset", 0);
    }

    /// Makes each mimic joint refer to one with a value of its own. Each joint is resolved once, before the joints
    /// that mimic it, so a long chain takes linear time.
    void resolve_mimics()
    {
        std::vector<bool> is_resolved(joints_.size(), false), is_waiting(joints_.size(), false);
        std::vector<std::uint32_t> waiting;
        for (std::uint32_t i = 0; i < joints_.size(); ++i) {
            for (std::uint32_t at = i; !is_resolved[at] && robot_.joints[at].mimics >= 0;
                 at = static_cast<std::uint32_t>(robot_.joints[at].mimics)) {
                if (is_waiting[at]) source_.fail_at(*joints_[i], "mimics itself, directly or through others");
                is_waiting[at] = true, waiting.push_back(at);
            }
            for (; !waiting.empty(); waiting.pop_back()) {
                RobotJoint& joint = robot_.joints[waiting.back()];
                const RobotJoint& of = robot_.joints[static_cast<std::size_t>(joint.mimics)];
                is_resolved[waiting.back()] = true;
                if (of.mimics < 0) continue;
                joint.offset += joint.multiplier * of.offset, joint.multiplier *= of.multiplier;
                joint.mimics = of.mimics;
            }
        }
    }

    const RobotSource& source_;
    const XmlElement root_;
    GeometryReader geometries_;
    RobotDescription robot_;
    std::vector<const XmlElement*> links_, joints_; ///< as in robot_
    std::unordered_map<std::string, std::uint32_t> link_numbers_, joint_numbers_;
};

} // namespace

RobotDescription read_urdf(const RobotSource& source, const std::filesystem::path& urdf, const RobotReading& reading)
{
    return UrdfReader(source, urdf, reading).read();
}

} // namespace oncollide
