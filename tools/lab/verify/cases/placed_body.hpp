#pragma once
#include <Eigen/Geometry>

#include <oncollide/scenes/geometry.hpp>

namespace oncollide::tools {

struct PlacedBody {
    GeometryData geometry;
    Eigen::Isometry3d pose;
};

inline Eigen::Isometry3d moved_to(const Eigen::Vector3d& at)
{
    return Eigen::Isometry3d(Eigen::Translation3d(at));
}

/// A map of one cell, whose lowest corner is the origin.
OccupancyMap one_cell(double side);

} // namespace oncollide::tools
