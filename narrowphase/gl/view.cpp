#include <oncollide/narrowphase/gl/picture.hpp>

#include <cmath>

namespace oncollide {

Eigen::Isometry3d view_of(const Camera& camera)
{
    const Eigen::Vector3d back = (camera.eye - camera.look_at).stableNormalized();
    const bool along_z = std::abs(back.z()) > 0.9999;
    const Eigen::Vector3d right =
        (along_z ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ()).cross(back).normalized();
    Eigen::Isometry3d view;
    view.linear() << right.transpose(), back.cross(right).transpose(), back.transpose();
    view.translation() = -view.linear() * camera.eye;
    return view;
}

} // namespace oncollide
