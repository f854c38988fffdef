#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/large_vector.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

class TerrainChunks;

/// Which diagonal cuts a cell into two triangles: from its least corner to its greatest (rising), or the other one.
enum class CellDiagonal : std::uint8_t { rising, falling };

/// How heights become a terrain.
struct TerrainGrid {
    std::uint32_t columns = 0, rows = 0;              ///< of heights: at least two each
    Eigen::Vector2d spacing{1, 1};                    ///< metres between columns and between rows
    Eigen::Vector3d origin = Eigen::Vector3d::Zero(); ///< where column 0, row 0 and height 0 are, metres
    std::optional<double> no_data{};                  ///< such heights are holes; may be not a number
    int bytes = 0;                                    ///< for each height: 1, 2, 4, 8; 0: the fewest that are exact
    double unit = 0;                                  ///< heights are probably whole multiples of it; 0: look
    double error = 0; ///< heights may be off by so much, besides what storing them adds, metres
    CellDiagonal diagonal = CellDiagonal::rising; ///< of all cells,
    std::vector<bool> falling{};                  ///< or of each, row by row, if it is not empty
};

/// A surface over a regular grid of heights, in its own frame: column c, row r is at origin + (c spacing, r spacing,
/// height). Each cell between four heights is two triangles; cells at a hole are absent. It has no inside.
///
/// Heights are kept in tiles of eight by eight. At 1 and 2 bytes they are whole numbers, relative to the tile's least,
/// of the terrain's unit times a power of two of the tile's own. Made by make_terrain, so: at least one cell. One in a
/// cooked file (load_terrain) reads of it what is looked at.
class Terrain {
public:
    static constexpr std::uint32_t tile = 8;
    static constexpr std::uint64_t most_cells = 1u << 31; ///< numbers of triangles have 32 bits

    std::uint32_t columns() const { return columns_; }
    std::uint32_t rows() const { return rows_; }
    std::uint32_t cells_x() const { return columns_ - 1; }
    std::uint32_t cells_y() const { return rows_ - 1; }
    const Eigen::Vector2d& spacing() const { return spacing_; }
    const Eigen::Vector3d& origin() const { return origin_; }
    const Aabb& bounds() const { return bounds_; } ///< of the surface, as given and as stored
    /// No true height is farther than this from the stored one, metres, nor is the true surface. 0: exact.
    double error() const { return error_; }
    bool holes() const { return holes_; }          ///< is a cell absent?
    std::uint64_t cells() const { return cells_; } ///< that are there
    int bytes_per_height() const { return 1 << samples_.index(); }
    std::size_t bytes() const;

    /// Not a number: a hole.
    double height(std::uint32_t column, std::uint32_t row) const
    {
        if (chunks_) return height_in_chunk(column, row);
        return std::visit([&](const auto& samples) { return height(samples, column, row); }, samples_);
    }
    double x(std::uint32_t column) const { return origin_.x() + column * spacing_.x(); }
    double y(std::uint32_t row) const { return origin_.y() + row * spacing_.y(); }
    Eigen::Vector3d point(std::uint32_t column, std::uint32_t row) const
    {
        return {x(column), y(row), origin_.z() + height(column, row)};
    }
    bool has_cell(std::uint32_t x, std::uint32_t y) const;
    bool mixed_diagonals() const { return mixed_; }
    CellDiagonal diagonal(std::uint32_t x, std::uint32_t y) const
    {
        if (!mixed_) return diagonal_;
        if (chunks_) return diagonal_in_chunk(x, y);
        const std::uint64_t cell = std::uint64_t(y) * cells_x() + x;
        return falling_[cell / 64] >> cell % 64 & 1 ? CellDiagonal::falling : CellDiagonal::rising;
    }

    /// Corners of a triangle: its columns and rows. Triangles of cell (x, y) have the numbers 2 (y cells_x + x) and the
    /// next; both turn counter-clockwise, seen from above.
    struct Place {
        std::uint32_t column, row;
    };
    std::array<Place, 3> corners(std::uint32_t triangle) const;

    /// The heights of a row, above `zero`: columns() of them. Cost: 1 ns a height.
    template <class Number>
    void read_row(std::uint32_t row, double zero, Number* out) const;
    /// Are the cells of row y there? cells_x() of them.
    void read_cells(std::uint32_t y, std::vector<bool>& there) const;
    /// Calls work(decode), where decode(column, row) is height(): for who needs a few, and so chooses the way of
    /// storage once.
    template <class Work>
    void with_heights(Work work) const
    {
        if (chunks_) return work([&](std::uint32_t column, std::uint32_t row) { return height_in_chunk(column, row); });
        std::visit(
            [&](const auto& samples) {
                work([&](std::uint32_t column, std::uint32_t row) { return height(samples, column, row); });
            },
            samples_);
    }

    /// Of one in a cooked file, of which chunks are read where heights are looked at, which then may throw ChunkFault;
    /// null: all of it is in memory.
    TerrainChunks* chunks() const { return chunks_.get(); }

private:
    friend class TerrainBuilder;
    friend class TerrainChunks;
    friend class CookedTerrain;
    friend Terrain centred(Terrain terrain);
    void find_bounds();
    double height_in_chunk(std::uint32_t column, std::uint32_t row) const;
    CellDiagonal diagonal_in_chunk(std::uint32_t x, std::uint32_t y) const;
    /// Heights of a tile are unit (base + (q << shift)).
    struct Tile {
        std::int32_t base = 0;
        std::uint32_t shift = 0;

        std::int32_t at(std::uint32_t q) const
        {
            return static_cast<std::int32_t>(static_cast<std::uint32_t>(base) + (q << shift));
        }
    };
    template <class Sample>
    double height(const LargeVector<Sample>& samples, std::uint32_t column, std::uint32_t row) const
    {
        const std::size_t number = std::size_t(row / tile) * tiles_x_ + column / tile;
        const Sample q = samples[number * (tile * tile) + row % tile * tile + column % tile];
        if constexpr (std::is_floating_point_v<Sample>) {
            return q;
        } else {
            if (q == std::numeric_limits<Sample>::max()) return std::numeric_limits<double>::quiet_NaN();
            const Tile& t = tiles_[number];
            return unit_ * static_cast<double>(t.at(q));
        }
    }

    Terrain() = default;

    std::uint32_t columns_ = 0, rows_ = 0, tiles_x_ = 0;
    Eigen::Vector2d spacing_;
    Eigen::Vector3d origin_;
    Place least_, greatest_;    ///< columns and rows between which the cells are
    double low_ = 0, high_ = 0; ///< heights between which they are
    Aabb bounds_;
    double error_ = 0, unit_ = 0;
    bool holes_ = false;
    std::uint64_t cells_ = 0;
    CellDiagonal diagonal_ = CellDiagonal::rising;
    bool mixed_ = false;                 ///< have cells a diagonal of their own?
    std::vector<std::uint64_t> falling_; ///< a bit a cell
    std::vector<Tile> tiles_;            ///< at 1 and 2 bytes
    std::variant<LargeVector<std::uint8_t>, LargeVector<std::uint16_t>, LargeVector<float>, LargeVector<double>>
        samples_;
    std::shared_ptr<TerrainChunks> chunks_; ///< in place of samples, tiles and diagonals
};

/// @param name     names the terrain in errors
/// @param heights  row by row, columns * rows, metres
/// Throws Error{bad_data} naming what is wrong: less than two rows or columns, more than 2^31 cells, another number of
/// heights, a spacing that is not positive or too small for coordinates so large (2^-30 of them), coordinates that are
/// not finite or beyond 1e15 m, a height that is not a number where no_data does not say that those are holes, or no
/// cell at all; Error{usage} for bytes other than 0, 1, 2, 4 and 8. Cost: 5 ns a height.
Terrain make_terrain(const std::string& name, const TerrainGrid& grid, std::span<const double> heights);
Terrain make_terrain(const std::string& name, const TerrainGrid& grid, std::span<const float> heights);

/// Hills over [0, cells_x spacing] x [0, cells_y spacing], at most `height` high; exact at 2 bytes or fewer.
/// Deterministic, on every platform. Throws Error{usage} for counts or sizes that make no terrain. Cost: 30 ns a cell.
Terrain make_hills(std::uint32_t cells_x, std::uint32_t cells_y, double spacing, double height, std::uint64_t seed);

/// Of make_hills(cells, cells, ...) the cells [x, x + size) x [y, y + size), as a mesh: the hills are made of such
/// parts. Throws Error{usage}.
Mesh make_hills_mesh(std::uint32_t cells, double spacing, double height, std::uint64_t seed, std::uint32_t x,
                     std::uint32_t y, std::uint32_t size);

/// With the bounding box's centre at the origin.
Terrain centred(Terrain terrain);

/// The same surface as a mesh: the cells' triangles row by row, the two of a cell in the order of their numbers; absent
/// cells have none. Throws Error{bad_data} for more triangles than a mesh can have.
Mesh mesh_of(const Terrain& terrain);

} // namespace oncollide
