#pragma once
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

// What is drawn of geometries that are no meshes.

/// The boxes of a map, twelve triangles each.
Mesh mesh_of_boxes(const std::string& name, const std::vector<Aabb>& boxes);
/// A shape's bounding mesh; of a half-space its plane, as far as the scene's bodies start from the origin.
Mesh drawn_mesh(const Shape& shape, const Scene& scene);

} // namespace oncollide::tools
