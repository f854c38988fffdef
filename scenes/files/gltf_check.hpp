#pragma once
#include <oncollide/scenes/files/mesh_source.hpp>

namespace oncollide {

/// Checks the parts of a glTF or GLB file that Assimp takes on trust (nesting, the node tree, sparse accessors,
/// strides), before Assimp sees it. Private to scenes. Throws Error{bad_data}.
/// @returns the number of triangles that the file's scene announces: Assimp silently leaves out those whose vertex
///          numbers are out of range, so fewer means a damaged file
std::size_t check_gltf(const MeshSource& source);

} // namespace oncollide
