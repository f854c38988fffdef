#pragma once
#include <cstdint>

#include <Eigen/Geometry>

namespace oncollide {

class Model;

/// A pair of bodies at their poses.
struct PairTask {
    std::uint32_t number; ///< index of the pair in the results and in the cache
    Model *a, *b;
    const Eigen::Isometry3d *pose_a, *pose_b;
    double travel = 0; ///< sum of the upper bounds of how far both bodies have moved
    double slack = -1; ///< stretch of both poses; negative: not known

    PairTask swapped() const { return {number, b, a, pose_b, pose_a, travel, slack}; }
};

/// The settings of an exact decision.
struct PairOptions {
    double clearance = 0;         ///< metres: bodies this close are near
    bool kinds = false;           ///< determine whether colliding surfaces touch or cross
    bool ignore_touching = false; ///< with kinds: surfaces that only touch are separate, with a bound of 0
};

} // namespace oncollide
