#include <oncollide/robots/kinematics.hpp>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/text/printable.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

namespace {

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v)
{
    Eigen::Matrix3d m;
    m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return m;
}

[[noreturn]] void refuse_joint(const RobotDescription& robot, const RobotJoint& joint, const std::string& what)
{
    refuse(fmt::format("robot '{}': joint '{}'", printable(robot.name), printable(joint.name)), what);
}

} // namespace

std::string_view name_of(JointKind kind)
{
    constexpr std::string_view names[] = {"fixed", "revolute", "continuous", "prismatic", "planar", "floating"};
    return names[static_cast<int>(kind)];
}

int Kinematics::numbers_of(const RobotJoint& joint)
{
    if (joint.mimics >= 0 || joint.kind == JointKind::fixed) return 0;
    return joint.kind == JointKind::planar ? 3 : joint.kind == JointKind::floating ? 7 : 1;
}

Kinematics::Kinematics(const RobotDescription& robot)
{
    constexpr std::uint32_t none = 0xffffffffu;
    const std::size_t links = robot.links.size(), joints = robot.joints.size();
    if (links == 0) refuse(fmt::format("robot '{}'", printable(robot.name)), "there is no link");
    std::vector<std::uint32_t> above(links, none);
    for (std::uint32_t i = 0; i < joints; ++i) {
        const RobotJoint& joint = robot.joints[i];
        if (joint.parent >= links || joint.child >= links) refuse_joint(robot, joint, "its link does not exist");
        if (const std::string why = why_not_rigid(joint.origin); !why.empty()) refuse_joint(robot, joint, why);
        if (above[joint.child] != none) refuse_joint(robot, joint, "another joint leads to its child");
        above[joint.child] = i;
        if (joint.mimics >= static_cast<std::int32_t>(joints) ||
            (joint.mimics >= 0 && numbers_of(robot.joints[static_cast<std::size_t>(joint.mimics)]) != 1))
            refuse_joint(robot, joint, "the joint that it mimics has not one value of its own");
        first_.push_back(numbers_of(joint) == 0 ? -1 : static_cast<int>(names_.size()));
        if (joint.kind == JointKind::planar && joint.mimics < 0)
            for (const char* part : {"x", "y", "angle"}) names_.push_back(joint.name + "/" + part);
        else if (joint.kind == JointKind::floating && joint.mimics < 0)
            for (const char* part : {"x", "y", "z", "qx", "qy", "qz", "qw"}) names_.push_back(joint.name + "/" + part);
        else if (numbers_of(joint) == 1)
            names_.push_back(joint.name);
    }
    root_ = static_cast<std::uint32_t>(std::ranges::find(above, none) - above.begin());
    // Breadth first: each round adds the joints below links that were reached.
    std::vector<std::uint32_t> reached{root_};
    for (std::size_t at = 0; at < reached.size() && reached.size() <= links; ++at)
        for (std::uint32_t i = 0; i < joints; ++i)
            if (robot.joints[i].parent == reached[at]) {
                reached.push_back(robot.joints[i].child);
                steps_.push_back(step_of(robot, i));
            }
    if (root_ == links || reached.size() != links)
        refuse(fmt::format("robot '{}'", printable(robot.name)), "its links are not one tree");
}

Kinematics::Step Kinematics::step_of(const RobotDescription& robot, std::uint32_t i) const
{
    const RobotJoint& joint = robot.joints[i];
    const bool mimics = joint.mimics >= 0;
    const int first = first_[mimics ? static_cast<std::size_t>(joint.mimics) : i];
    const Eigen::Matrix3d turn = joint.origin.linear(), k = cross_matrix(joint.axis);
    Step step{joint.parent,
              joint.child,
              joint.kind,
              static_cast<std::uint32_t>(std::max(first, 0)),
              mimics ? joint.multiplier : 1,
              mimics ? joint.offset : 0,
              turn,
              Eigen::Matrix3d::Zero(),
              Eigen::Matrix3d::Zero(),
              joint.origin.translation(),
              turn * joint.axis,
              joint.origin,
              joint.axis};
    if (joint.kind == JointKind::revolute || joint.kind == JointKind::continuous) // Rodrigues' formula
        step.constant = turn * (Eigen::Matrix3d::Identity() + k * k), step.by_sine = turn * k,
        step.by_cosine = -turn * k * k;
    return step;
}

void Kinematics::link_poses(const double* numbers, const Eigen::Isometry3d& base, Eigen::Isometry3d* poses) const
{
    poses[root_] = base;
    for (const Step& step : steps_) {
        const Eigen::Isometry3d& parent = poses[step.parent];
        Eigen::Isometry3d& child = poses[step.child];
        child.makeAffine();
        const double value = step.kind == JointKind::fixed ? 0 : numbers[step.number] * step.multiplier + step.offset;
        switch (step.kind) {
        case JointKind::fixed:
            child = parent * step.origin;
            break;
        case JointKind::prismatic:
            child.linear() = parent.linear() * step.constant;
            child.translation() = parent.linear() * (step.translation + value * step.along) + parent.translation();
            break;
        case JointKind::revolute:
        case JointKind::continuous: {
            const Eigen::Matrix3d turn =
                step.constant + std::sin(value) * step.by_sine + std::cos(value) * step.by_cosine;
            child.linear() = parent.linear() * turn;
            child.translation() = parent.linear() * step.translation + parent.translation();
            break;
        }
        case JointKind::planar: { // in the plane across the axis
            const Eigen::Matrix3d tilt =
                Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), step.axis).toRotationMatrix();
            Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
            motion.translation() = tilt * Eigen::Vector3d(numbers[step.number], numbers[step.number + 1], 0);
            motion.linear() = Eigen::AngleAxisd(numbers[step.number + 2], step.axis).toRotationMatrix();
            child = parent * step.origin * motion;
            break;
        }
        case JointKind::floating: {
            const double* n = numbers + step.number;
            Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
            motion.translation() << n[0], n[1], n[2];
            motion.linear() = Eigen::Quaterniond(n[6], n[3], n[4], n[5]).normalized().toRotationMatrix();
            child = parent * step.origin * motion;
            break;
        }
        }
    }
}

} // namespace oncollide
