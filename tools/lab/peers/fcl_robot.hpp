#pragma once
#include <memory>
#include <span>
#include <vector>

#include <oncollide/robots/robot.hpp>

namespace oncollide::tools {

/// A robot in FCL, as MoveIt has it: OBBRSS trees for meshes, a tree of AABBs for the links and one for the
/// environment, the pairs of the SRDF excluded, and a stop at the first contact.
class FclRobot {
public:
    explicit FclRobot(const RobotDescription& robot);
    ~FclRobot();

    /// Replaces the environment.
    void set_environment(std::span<const LinkGeometry> obstacles);
    /// @param links  the poses of the links
    bool self_collides(std::span<const Eigen::Isometry3d> links);
    bool collides(std::span<const Eigen::Isometry3d> links);
    /// The least distance of a link and another or the environment, with nearest points; not above 0: some meet.
    double distance(std::span<const Eigen::Isometry3d> links);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace oncollide::tools
