#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

class TerrainChunks;
struct TerrainHeights;

/// The diagonal that cuts a cell into two triangles: from its least corner to its greatest (rising), or the other one.
enum class CellDiagonal : std::uint8_t { rising, falling };

/// Layout and storage of heights, for make_terrain.
struct TerrainGrid {
    std::uint32_t columns = 0, rows = 0;              ///< numbers of heights: at least two each
    Eigen::Vector2d spacing{1, 1};                    ///< metres between columns and between rows
    Eigen::Vector3d origin = Eigen::Vector3d::Zero(); ///< position of column 0, row 0 and height 0, metres
    std::optional<double> no_data{};                  ///< heights of this value are holes; may be NaN
    int bytes = 0;                                    ///< for each height: 1, 2, 4, 8; 0: the smallest size that is
                                                      ///< exact
    double unit = 0;                                  ///< heights are probably integer multiples of it; 0: unknown
    double error = 0; ///< bound on the error of the given heights, metres; the error of storing them is added
    CellDiagonal diagonal = CellDiagonal::rising; ///< diagonal of all cells,
    std::vector<bool> falling{};                  ///< if not empty, true for each cell, row by row, that has the
                                                  ///< falling diagonal
};

/// Heights of a terrain: some of its columns, in some of its rows.
struct TerrainRectangle {
    std::uint32_t column = 0, row = 0;   ///< the first ones
    std::uint32_t columns = 0, rows = 0; ///< their numbers
};

/// A surface over a regular grid of heights, in its own frame: column c, row r is at origin + (c spacing, r spacing,
/// height). Each cell between four heights is two triangles; cells at a hole are absent. It has no inside.
///
/// Heights are stored in tiles of eight by eight. At 1 and 2 bytes they are integers, relative to the tile's least, in
/// units of the terrain's unit times a power of two that each tile chooses. make_terrain guarantees at least one cell.
/// Copies share the heights. A terrain in a cooked file (load_terrain) reads the parts that are used.
class ONCOLLIDE_API Terrain {
public:
    static constexpr std::uint32_t tile = 8;
    static constexpr std::uint64_t most_cells = 1u << 31; ///< triangle indices have 32 bits

    std::uint32_t columns() const { return columns_; }
    std::uint32_t rows() const { return rows_; }
    std::uint32_t cells_x() const { return columns_ - 1; }
    std::uint32_t cells_y() const { return rows_ - 1; }
    const Eigen::Vector2d& spacing() const { return spacing_; }
    const Eigen::Vector3d& origin() const { return origin_; }
    const Aabb& bounds() const { return bounds_; } ///< bounds of the surface, both as given and as stored
    /// Bound, in metres, on the error of the stored heights and of the surface through them. 0: exact.
    double error() const { return error_; }
    bool holes() const { return holes_; } ///< true if a cell is absent
    /// As TerrainGrid::no_data; empty for a terrain in a cooked file.
    const std::optional<double>& no_data() const { return no_data_; }
    std::uint64_t cells() const { return cells_; } ///< number of present cells
    int bytes_per_height() const { return bytes_; }
    std::size_t bytes() const;

    // Columns and rows are below columns() and rows(), cells below cells_x() and cells_y(); others are undefined.

    /// NaN: a hole. As all access to a terrain in a cooked file, throws Error{bad_data} if a part cannot be read.
    double height(std::uint32_t column, std::uint32_t row) const;
    double x(std::uint32_t column) const;
    double y(std::uint32_t row) const;
    Eigen::Vector3d point(std::uint32_t column, std::uint32_t row) const;
    bool has_cell(std::uint32_t x, std::uint32_t y) const;
    bool mixed_diagonals() const { return mixed_; }
    CellDiagonal diagonal(std::uint32_t x, std::uint32_t y) const;

    /// Corners of a triangle: its columns and rows. The triangles of cell (x, y) have the numbers 2 (y cells_x + x) and
    /// the next; both are counter-clockwise, seen from above.
    struct Place {
        std::uint32_t column, row;
    };
    std::array<Place, 3> corners(std::uint32_t triangle) const;

    /// The columns() heights of a row, relative to `zero`. Cost: 1 ns per height.
    template <class Number>
    void read_row(std::uint32_t row, double zero, Number* out) const;
    /// Whether each of the cells_x() cells of row y is present.
    void read_cells(std::uint32_t y, std::vector<bool>& there) const;

private:
    friend class TerrainBuilder;
    friend class HeightMover;
    friend struct TerrainAccess;
    friend class TerrainChunks;
    friend class CookedTerrain;
    friend Terrain centred(Terrain terrain);
    void find_bounds();

    Terrain() = default;

    std::uint32_t columns_ = 0, rows_ = 0, tiles_x_ = 0;
    Eigen::Vector2d spacing_;
    Eigen::Vector3d origin_;
    Place least_, greatest_;    ///< columns and rows that bound the present cells
    double low_ = 0, high_ = 0; ///< heights that bound the present cells
    Aabb bounds_;
    double error_ = 0, unit_ = 0;
    std::optional<double> no_data_;
    bool holes_ = false;
    std::uint64_t cells_ = 0;
    CellDiagonal diagonal_ = CellDiagonal::rising;
    bool mixed_ = false; ///< true if each cell has its own diagonal
    int bytes_ = 0;      ///< per height
    std::shared_ptr<const TerrainHeights> heights_;
    std::shared_ptr<TerrainChunks> chunks_; ///< holds the heights of a terrain in a cooked file
};

/// @param name     names the terrain in errors
/// @param heights  row by row, columns * rows, metres
/// Throws Error{bad_data} naming the fault: less than two rows or columns, more than 2^31 cells, a wrong number of
/// heights, a spacing that is not positive or too small for such large coordinates (2^-30 of them), coordinates that
/// are not finite or beyond 1e15 m, a NaN height unless no_data is NaN, or no cell at all; Error{usage} for bytes other
/// than 0, 1, 2, 4 and 8. Cost: 5 ns per height.
ONCOLLIDE_API Terrain make_terrain(const std::string& name, const TerrainGrid& grid, std::span<const double> heights);
ONCOLLIDE_API Terrain make_terrain(const std::string& name, const TerrainGrid& grid, std::span<const float> heights);

/// Moves the terrain so that its bounds' centre is at the origin.
ONCOLLIDE_API Terrain centred(Terrain terrain);

/// The same surface as a mesh: the cells' triangles row by row, the two of a cell in the order of their numbers; absent
/// cells have none. Throws Error{bad_data} for more triangles than a mesh can have.
ONCOLLIDE_API Mesh mesh_of(const Terrain& terrain);

} // namespace oncollide
