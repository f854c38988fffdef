// Scenes of rigid bodies for 'bench contacts'.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/geometry.hpp>

namespace oncollide::tools {

struct ContactBody {
    std::shared_ptr<const Geometry> geometry;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    Eigen::Vector3d half = Eigen::Vector3d::Zero(); ///< of the box that has its mass; 0: it does not move
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
};

/// Bodies, and how the reference solver plays them.
struct ContactScene {
    std::string name{}, what{};
    std::vector<ContactBody> bodies{};
    double dt = 1e-3, friction = 0.5, margin = 1e-3, slop = 1e-4;
    int steps = 0;         ///< 0: the poses as they are
    int timed = 1;         ///< steps at the end that are timed
    double most_creep = 0; ///< limit of the speed of all bodies at the end, m/s; 0: no limit
};

/// Files that replace generated meshes, or add scenes; empty: none.
struct ContactFiles {
    std::string cow, nut, bolt;
};

/// The scenes of these names (all: empty), in the order of the table. Throws Error{usage} with the valid names.
std::vector<ContactScene> contact_scenes(const std::vector<std::string>& names, const ContactFiles& files);

} // namespace oncollide::tools
