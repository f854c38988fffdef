#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// How the file's coordinates become the mesh's: scale, then fit, then centre.
struct MeshOptions {
    double scale = 1.0;      ///< metres per unit of the file; finite, > 0
    double fit_diagonal = 0; ///< if > 0: scale again so that the bounding box's diagonal has this length
    bool centre = false;     ///< move the bounding box's centre to the origin

    friend bool operator==(const MeshOptions&, const MeshOptions&) = default;
};

/// Reads OBJ, STL (text and binary), PLY (text and binary), OFF (text), glTF, GLB, COLLADA, 3MF, and cooked files as a
/// whole (docs/cooked.md). Coordinates are the file's, in double: no digit of a text file is lost. COLLADA and 3MF
/// declare their unit and are converted to metres; z is up if the file declares its up axis. Polygons are triangulated;
/// zero-area triangles stay; points and lines are ignored; all parts of the file, placed by its node tree, become one
/// mesh. Vertices keep the file's order (OBJ, PLY, OFF); in formats that may repeat them (STL, glTF, COLLADA, 3MF),
/// equal positions become one vertex. Throws Error{no_input} if the file is missing, unreadable or a folder;
/// Error{bad_data} if it is empty, too large (over 2 GiB), truncated, malformed, of an unknown kind, or has no
/// triangle; Error{usage} for options out of range. Messages begin with the path and name the line of a text file. (A
/// text file cut at the end of a line may go undetected: OBJ announces no counts.) Cost: reading the file; memory for
/// the file, the mesh and, for STL and glTF, a table of its points at the same time.
Mesh load_mesh(const std::filesystem::path& path, const MeshOptions& options = {});

/// The extensions that load_mesh accepts, lower case, without the dot.
const std::vector<std::string>& mesh_extensions();

} // namespace oncollide
