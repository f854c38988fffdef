#pragma once
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/robots/robot.hpp>

namespace oncollide {

/// The joints of a robot in an order in which each follows the joints above it.
class Kinematics {
public:
    /// Throws Error{bad_data} unless the links are a tree.
    explicit Kinematics(const RobotDescription& robot);

    const std::vector<std::string>& names() const { return names_; }
    std::size_t width() const { return names_.size(); }
    std::uint32_t root() const { return root_; }
    /// The joint's first number in a configuration; -1: it has none of its own.
    int first_number(std::uint32_t joint) const { return first_[joint]; }
    /// `numbers` must be finite, quaternions unit.
    void link_poses(const double* numbers, const Eigen::Isometry3d& base, Eigen::Isometry3d* poses) const;

    static int numbers_of(const RobotJoint& joint);

private:
    /// The pose of a child in its parent's frame, as a function of the joint's value v: a rotation joint's linear part
    /// is constant + sin(v) * by_sine + cos(v) * by_cosine.
    struct Step {
        std::uint32_t parent, child;
        JointKind kind;
        std::uint32_t number;
        double multiplier, offset;
        Eigen::Matrix3d constant, by_sine, by_cosine;
        Eigen::Vector3d translation, along; ///< along: per unit of a prismatic joint
        Eigen::Isometry3d origin;
        Eigen::Vector3d axis;
    };
    Step step_of(const RobotDescription& robot, std::uint32_t joint) const;

    std::vector<std::string> names_;
    std::vector<int> first_;
    std::vector<Step> steps_;
    std::uint32_t root_ = 0;
};

} // namespace oncollide
