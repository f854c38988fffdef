#pragma once
#include <Eigen/Geometry>

#include <oncollide/samples/generators.hpp>

namespace oncollide::world_test {

inline Mesh knot()
{
    return make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300);
}

inline Eigen::Isometry3d at(double x, double y = 0, double z = 0)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = Eigen::Vector3d(x, y, z);
    return pose;
}

} // namespace oncollide::world_test
