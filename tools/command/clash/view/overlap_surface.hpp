#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

/// A closed mesh at a pose.
struct PlacedMesh {
    const Mesh& mesh;
    Eigen::Isometry3d pose;
};

/// The surface of the common part of two closed meshes, as triangles, for pictures: the faces of each inside the
/// other, cut where the other's faces pass. Accurate to rounding, not certified; pieces of a share below 1e-12 of a
/// face are left out. Cost: some microseconds per triangle of the result, and 0.1 per triangle of both meshes.
/// @param contacts  all contacts of both
/// @param depth     how thick the common part is: the diameter of a ball inside
/// @param most      limit on the triangles; if more are needed the result is empty
std::vector<std::array<Eigen::Vector3d, 3>> overlap_surface(const PlacedMesh& a, const PlacedMesh& b,
                                                            const std::vector<Contact>& contacts, double depth,
                                                            std::size_t most);

} // namespace oncollide::tools
