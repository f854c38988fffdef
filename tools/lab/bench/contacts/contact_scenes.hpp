// Scenes of rigid bodies for 'bench contacts'.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/geometry.hpp>

namespace oncollide::tools {

using Poses = std::vector<Eigen::Isometry3d>; ///< of all bodies

struct ContactBody {
    std::shared_ptr<const Geometry> geometry;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    Eigen::Vector3d half = Eigen::Vector3d::Zero(); ///< of the box that has its mass; 0: it does not move
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
};

/// The poses of the bodies while the contacts are found.
struct ContactSteps {
    std::string mode{};         ///< its name in the table
    Poses first{};              ///< of the first call
    std::vector<Poses> steps{}; ///< timed, again and again; no poses: nothing moves in this step
};

/// Bodies, and either how the reference solver plays them or where they are in each step.
struct ContactScene {
    std::string name{}, what{};
    std::vector<ContactBody> bodies{};
    double dt = 1e-3, friction = 0.5, margin = 1e-3, slop = 1e-4;
    int steps = 0;                     ///< of the solver; 0: the poses as they are
    int timed = 1;                     ///< steps at the end that are timed
    double most_creep = 0;             ///< limit of the speed of all bodies at the end, m/s; 0: no limit
    std::vector<ContactSteps> modes{}; ///< not empty: no solver
    bool pairs_alone = false;          ///< bodies 2 i and 2 i + 1 are a pair; all pairs are known, and times are of one
};

struct ContactEntry {
    std::string name;
    std::function<ContactScene()> make;
};

/// Files that replace generated meshes, or add scenes; empty: none.
struct ContactFiles {
    std::string cow, nut, bolt;
};

/// The scenes of these names (all: empty), in the order of the table. Throws Error{usage} with the valid names.
/// @param bodies  number of bodies of a scene of shapes; 0: as its name says
std::vector<ContactEntry> contact_scenes(const std::vector<std::string>& names, const ContactFiles& files, int bodies);

} // namespace oncollide::tools
