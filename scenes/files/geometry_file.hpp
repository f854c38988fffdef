#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/geometry.hpp>

namespace oncollide {

// Files that hold one geometry: a mesh, an occupancy map or a terrain.

/// Reads a mesh, a map or a terrain from a file of any format, with default options, as load_mesh, load_octomap and
/// load_terrain do; its name is the path. A cooked mesh stays in its file: tests read the parts that they need. Throws
/// as those functions do. Cost: theirs.
ONCOLLIDE_API std::shared_ptr<Geometry> load_geometry(const std::filesystem::path& path);

/// The kind of geometry that a file holds, by its extension; mesh for an unknown extension. `cooked` may hold each
/// kind.
enum class FileKind : std::uint8_t { mesh, map, terrain, cooked };
ONCOLLIDE_API FileKind kind_of_file(const std::filesystem::path& path);

/// Calls `watch` with one line, "FILE: TEXT", for each thing that a reader leaves out or has to assume, such as the
/// skin of a glTF mesh. The line is safe to print. Null, the default: such lines are dropped. Several threads may call
/// it at once. Call only while no file is being read.
using FileWarningWatcher = void (*)(const std::string& line);
ONCOLLIDE_API void on_file_warning(FileWarningWatcher watch);

// --- Meshes.

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
ONCOLLIDE_API Mesh load_mesh(const std::filesystem::path& path, const MeshOptions& options = {});

/// The extensions that load_mesh accepts, lower case, without the dot.
ONCOLLIDE_API std::vector<std::string> mesh_extensions();

/// Makes a GLB file, in metres, of a file in another format; returns its bytes. Throws Error.
using FileConverter = std::function<std::string(const std::filesystem::path&)>;

/// From now on load_mesh and load_assembly read files with these extensions (lower case, without the dot), too: as the
/// GLB file that `convert` makes of them. Their messages name the file itself. Replaces the converter of an earlier
/// call; null: there is none. Several threads may call `convert` at once. Call only while no file is being read.
ONCOLLIDE_API void convert_files(std::vector<std::string> extensions, FileConverter convert);

// --- Occupancy maps.

/// Options of load_octomap.
struct MapOptions {
    bool unknown_is_occupied = false; ///< as for make_occupancy_map()
    /// Cells of at least this probability are occupied; above 0 and below 1; by default 0.5, as in OctoMap. Only for
    /// `.ot` files: a `.bt` file holds no probabilities.
    std::optional<double> occupancy_threshold{};
};

/// Reads `.bt` and `.ot` files of an OcTree, or of a ColorOcTree without its colours. Throws Error{no_input},
/// Error{bad_data} (empty, truncated, wrong kind, no occupied cell) or Error{usage} for a threshold out of range. As in
/// OctoMap, a `.bt` file whose root has no children means that the whole grid is occupied. The probabilities of a `.ot`
/// file are kept for later scans. Cost: a `.bt` file 10 ns per byte and 4 bytes per byte.
ONCOLLIDE_API OccupancyMap load_octomap(const std::filesystem::path& path, const MapOptions& options = {});

/// Writes the known cells as a `.bt` file (temporary name, then renamed). Throws Error{cannot_write}.
ONCOLLIDE_API void save_octomap(const OccupancyMap& map, const std::filesystem::path& path);

// --- Terrains.

/// Options of load_terrain.
struct TerrainOptions {
    std::optional<Eigen::Vector2d> spacing{};         ///< metres; default: from the file, else 1
    Eigen::Vector3d origin = Eigen::Vector3d::Zero(); ///< position of the first column and row, and of height 0
    double vertical_scale = 1;                        ///< metres per unit of the file's heights; > 0
    std::optional<double> no_data{};                  ///< in the file's units; may be NaN; default: from the file
    int bytes = 0;                                    ///< as TerrainGrid::bytes
    double error = 0;                                 ///< bound on the error of the heights, metres
    bool centre = false; ///< move the bounding box's centre to the origin; overrides `origin`
    CellDiagonal diagonal = CellDiagonal::rising;
    std::filesystem::path diagonals{}; ///< a .npy file of rows - 1 times columns - 1 bytes, 1 for a cell cut along its
                                       ///< falling diagonal; empty: all cells have the same diagonal
    // For raw arrays, which have no header:
    std::uint32_t columns = 0, rows = 0;
    std::string type{}; ///< as NumPy writes it: "<i2", ">u2", "|u1", "<f4", "<f8" ...

    friend bool operator==(const TerrainOptions&, const TerrainOptions&) = default;
};

/// Reads PGM (P5, 8 and 16 bits), PNG (grey, 8 and 16 bits), NumPy arrays (.npy), raw arrays (.raw, .bin), and the
/// files that GDAL reads as GeoTIFF or DEM (.tif, .tiff, .dem, .asc, .hgt, .vrt, .img), if the build has GDAL. The
/// file's first row becomes row 0, at the least y. In GDAL's files the first row is the northernmost: there the order
/// is reversed, so that y points north. Throws Error{no_input} if the file is missing, unreadable or a folder;
/// Error{bad_data} if it is empty, too large (over 8 GiB), cut off, malformed, of an unknown kind, or refused by
/// make_terrain; Error{usage} for options that are out of range, that do not apply to a cooked file (.cooked, whose
/// chunks are read on first use), or that need GDAL in a build without it. Allocates nothing for sizes in a header that
/// exceed the file. Cost: reading the file; 8 more bytes per height.
ONCOLLIDE_API Terrain load_terrain(const std::filesystem::path& path, const TerrainOptions& options = {});

/// The extensions that load_terrain accepts, lower case, without the dot.
ONCOLLIDE_API const std::vector<std::string>& terrain_extensions();

/// Writes the heights as a .npy file of doubles, holes as NaN; and the diagonals, if cells differ, to
/// diagonals_file(path). (Temporary names, then renamed.) Throws Error{cannot_write}.
ONCOLLIDE_API void save_terrain(const Terrain& terrain, const std::filesystem::path& path);
ONCOLLIDE_API std::string diagonals_file(const std::string& path);

} // namespace oncollide
