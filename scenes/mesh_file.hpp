#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/scenes/mesh.hpp>

namespace oncollide {

/// How a mesh file's coordinates become the mesh's: scale, then fit, then centre.
struct MeshOptions {
    double scale = 1.0;      ///< metres per unit of the file; finite, > 0
    double fit_diagonal = 0; ///< when > 0: scale again so that the bounding box's diagonal is this long
    bool centre = false;     ///< move the bounding box's centre to the origin
};

/// Reads OBJ, STL (text and binary), PLY, OFF, glTF and GLB through Assimp. Polygons are triangulated; all parts of the
/// file, placed by its node tree, become one mesh.
/// Throws Error{no_input} when the file is missing, unreadable or a folder; Error{bad_data} when it is empty, too large
/// (over 2 GiB), truncated, malformed, of an unknown kind, or holds no triangle. Messages begin with the path.
/// Cost: reading the file; peak memory about ten times its size.
Mesh load_mesh(const std::filesystem::path& path, const MeshOptions& options = {});

/// The extensions that load_mesh knows, lower case, without the dot.
const std::vector<std::string>& mesh_extensions();

} // namespace oncollide
