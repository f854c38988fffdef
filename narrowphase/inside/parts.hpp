#pragma once
#include <array>
#include <string>
#include <vector>

#include <oncollide/scenes/geometry.hpp>

namespace oncollide {

/// Points of a connected part of a geometry; for a mesh, the part's least and largest vertices along the axes. A part
/// that does not meet a surface is completely on one side of it: any point decides which, and testing several finds an
/// outside part sooner.
using PartPoints = std::array<Eigen::Vector3d, 6>;

/// The parts of a mesh or a terrain, where cells that share a corner belong to one part. A shape is one part. Empty for
/// a map, where each cell is a part. Cost: O(triangles).
std::vector<PartPoints> part_points_of(const GeometryData& geometry);
std::vector<PartPoints> part_points_of(const Mesh& mesh);
std::vector<PartPoints> part_points_of(const Terrain& terrain);

/// Throws Error{bad_data}, which names a mesh that is not closed, and its first open edges.
[[noreturn]] void refuse_open_mesh(const std::string& name, const Mesh& mesh);

} // namespace oncollide
