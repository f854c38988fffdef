#pragma once
#include <cstdint>
#include <span>

#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

// Meshes for drawing geometries that are not meshes, and parts of meshes.

/// A map's cells, twelve triangles per cell.
Mesh mesh_of_boxes(const std::string& name, const std::vector<Aabb>& boxes);
/// A shape's bounding mesh. For a half-space it is the plane, as far as the scene's bodies start from the origin.
Mesh drawn_mesh(const Shape& shape, const Scene& scene);
/// Some triangles of a mesh with their vertices.
Mesh part_of(const Mesh& mesh, std::span<const std::uint32_t> triangles);

} // namespace oncollide::tools
