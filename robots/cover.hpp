#pragma once
#include <span>
#include <vector>

#include <Eigen/Core>

#include <oncollide/base/aabb.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// A sphere in the frame of a geometry or a link.
struct CoverSphere {
    Eigen::Vector3d centre;
    double radius;
};

/// A sphere that contains the points; at most about 1 % larger than the smallest.
CoverSphere enclosing_sphere(std::span<const Eigen::Vector3d> points);

/// A sphere that contains the spheres, around the middle of their centres.
CoverSphere around_spheres(std::span<const CoverSphere> spheres);

/// At most `count` spheres that together contain every triangle: the triangles are halved along the longest axis of
/// their centres, and each part gets one sphere.
std::vector<CoverSphere> cover_triangles(const Mesh& mesh, std::size_t count);

/// At most `count` spheres that together contain the solid box: slices along its longest axis.
std::vector<CoverSphere> cover_box(const Aabb& box, std::size_t count);

} // namespace oncollide
