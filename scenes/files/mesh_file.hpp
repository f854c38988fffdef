#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// How a mesh file's coordinates become the mesh's: scale, then fit, then centre.
struct MeshOptions {
    double scale = 1.0;      ///< metres per unit of the file; finite, > 0
    double fit_diagonal = 0; ///< when > 0: scale again so that the bounding box's diagonal is this long
    bool centre = false;     ///< move the bounding box's centre to the origin

    friend bool operator==(const MeshOptions&, const MeshOptions&) = default;
};

/// Reads OBJ, STL (text and binary), PLY (text and binary), OFF (text), glTF, GLB, COLLADA, 3MF, and all of a cooked
/// file (docs/cooked.md). Coordinates are the file's own, in double: no digit of a text file is lost. Of COLLADA and
/// 3MF, which say what their unit is, they are metres, and z is up where a file says what is up. Polygons are triangulated; zero-area triangles stay; points and lines
/// are left out; all parts of the file, placed by its node tree, become one mesh. Vertices keep the file's order (OBJ,
/// PLY, OFF); where the format may repeat them (STL, glTF, COLLADA, 3MF), equal positions become one vertex. Throws
/// Error{no_input} when the file is missing, unreadable or a folder; Error{bad_data} when it is empty, too large (over
/// 2 GiB), truncated, malformed, of an unknown kind, or holds no triangle; Error{usage} for options out of range.
/// Messages begin with the path and name the line of a text file. (A text file cut at the end of a line may be whole as
/// far as its format tells: OBJ announces no counts.) Cost: reading the file; in memory at the
/// same time the file, the mesh and, of STL and glTF, a table of its points.
Mesh load_mesh(const std::filesystem::path& path, const MeshOptions& options = {});

/// The extensions that load_mesh knows, lower case, without the dot.
const std::vector<std::string>& mesh_extensions();

} // namespace oncollide
