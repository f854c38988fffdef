#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

/// Options of load_terrain.
struct TerrainOptions {
    std::optional<Eigen::Vector2d> spacing{};         ///< metres; default: from the file, else 1
    Eigen::Vector3d origin = Eigen::Vector3d::Zero(); ///< of the first column and row, and of height 0
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
/// make_terrain; Error{usage} for options out of range or given for a cooked file (.cooked, whose chunks are read on
/// first use), and for a file of GDAL in a build without it. Allocates nothing for sizes in a header that exceed the
/// file. Cost: reading the file; 8 more bytes per height.
Terrain load_terrain(const std::filesystem::path& path, const TerrainOptions& options = {});

/// The extensions that load_terrain accepts, lower case, without the dot.
const std::vector<std::string>& terrain_extensions();

/// Writes the heights as a .npy file of doubles, holes as NaN; and the diagonals, if cells differ, to
/// diagonals_file(path). (Temporary names, then renamed.) Throws Error{cannot_write}.
void save_terrain(const Terrain& terrain, const std::filesystem::path& path);
std::string diagonals_file(const std::string& path);

} // namespace oncollide
