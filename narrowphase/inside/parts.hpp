#pragma once
#include <array>
#include <string>
#include <vector>

#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// Points of a connected part of a geometry: of a mesh its least and largest vertices along the axes. Where the part
/// does not meet a surface, all of it is on one side: one point tells, and the others quickly show where that is not
/// the inside.
using PartPoints = std::array<Eigen::Vector3d, 6>;

/// The parts of a mesh; of a terrain, whose cells that share corners are one; of a shape, which is one; none of a map,
/// of which each cell is one. Cost: O(triangles).
std::vector<PartPoints> part_points_of(const GeometryData& geometry);
std::vector<PartPoints> part_points_of(const Mesh& mesh);
std::vector<PartPoints> part_points_of(const Terrain& terrain);

/// Throws Error{bad_data} that names a mesh which is not closed, and its first open edges.
[[noreturn]] void refuse_open_mesh(const std::string& name, const Mesh& mesh);

} // namespace oncollide
