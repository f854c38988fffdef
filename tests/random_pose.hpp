#pragma once
#include <cstdint>

#include <Eigen/Geometry>

#include <oncollide/base/numbers/random.hpp>

namespace oncollide {

/// Any rotation; each coordinate within `reach`. Deterministic for a seed.
inline Eigen::Isometry3d random_pose(std::uint64_t seed, double reach)
{
    Eigen::Vector4d q;
    for (std::uint64_t k = 0; k < 4; ++k) q[int(k)] = u01(seed, 1, k) - 0.5;
    Eigen::Isometry3d pose(Eigen::Quaterniond(q.normalized()));
    for (std::uint64_t k = 0; k < 3; ++k) pose.translation()[int(k)] = reach * (2 * u01(seed, 2, k) - 1);
    return pose;
}

} // namespace oncollide
