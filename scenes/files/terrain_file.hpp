#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

/// How a file of heights becomes a terrain.
struct TerrainOptions {
    std::optional<Eigen::Vector2d> spacing{};         ///< metres; default: what the file says, else 1
    Eigen::Vector3d origin = Eigen::Vector3d::Zero(); ///< of the first column and row, and of height 0
    double vertical_scale = 1;                        ///< metres for each unit of the file's heights; > 0
    std::optional<double> no_data{}; ///< in the file's units; may be not a number; default: what the file says
    int bytes = 0;                   ///< as TerrainGrid::bytes
    double error = 0;                ///< heights may be off by so much, metres
    bool centre = false;             ///< move the bounding box's centre to the origin, whatever `origin` says
    CellDiagonal diagonal = CellDiagonal::rising;
    std::filesystem::path diagonals{}; ///< a .npy file of rows - 1 times columns - 1 bytes, 1 where a cell is cut along
                                       ///< its falling diagonal; empty: all are cut alike
    // Of raw arrays, which do not say it:
    std::uint32_t columns = 0, rows = 0;
    std::string type{}; ///< as NumPy writes it: "<i2", ">u2", "|u1", "<f4", "<f8" ...

    friend bool operator==(const TerrainOptions&, const TerrainOptions&) = default;
};

/// Reads PGM (P5, 8 and 16 bits), PNG (grey, 8 and 16 bits), NumPy arrays (.npy), raw arrays (.raw, .bin), and what
/// GDAL reads as GeoTIFF or DEM (.tif, .tiff, .dem, .asc, .hgt, .vrt, .img), where the build has GDAL. The file's first
/// row is the terrain's, at the least y; but GDAL's, whose first row is the northernmost, has y to the north.
/// Throws Error{no_input} when the file is missing, unreadable or a folder; Error{bad_data} when it is empty, too large
/// (over 8 GiB), cut off, malformed, of an unknown kind, or as make_terrain says; Error{usage} for options out of
/// range or given for a cooked file (.cooked, of which chunks are read where heights are looked at), and for a file of
/// GDAL in a build without it. Allocates nothing for what a header announces that the file cannot hold. Cost: reading
/// the file; 8 bytes a height besides.
Terrain load_terrain(const std::filesystem::path& path, const TerrainOptions& options = {});

/// The extensions that load_terrain knows, lower case, without the dot.
const std::vector<std::string>& terrain_extensions();

/// Writes the heights as a .npy file of doubles, holes as not a number; and the diagonals, where cells differ, to
/// diagonals_file(path). (Temporary names, then renamed.) Throws Error{cannot_write}.
void save_terrain(const Terrain& terrain, const std::filesystem::path& path);
std::string diagonals_file(const std::string& path);

} // namespace oncollide
