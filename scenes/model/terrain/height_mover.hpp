#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/scenes/model/terrain/terrain_access.hpp>

namespace oncollide {

/// Throws Error{bad_data} that names the height and the limit.
[[noreturn]] void refuse_height(const std::string& name, std::size_t column, std::size_t row, double height);

/// The result of a change of heights.
struct HeightMove {
    double distance = 0; ///< upper bound of the distance that a point of the surface moved
    bool holes = false;  ///< heights became holes, or holes became heights
    bool any() const { return distance > 0 || holes; }
};

/// Returns the effect of a change of heights, without making it. NaN is a hole, as is the terrain's no_data(). Throws
/// Error{bad_data} that names a height that is not finite or too far, or a hole in a terrain without no_data(), or if
/// no cell would be left. Cost: O(heights).
/// @param heights  row by row
HeightMove examine_heights(const std::string& name, const Terrain& terrain, const TerrainRectangle& where,
                           std::span<const double> heights);

/// Changes the heights of one terrain in memory.
class HeightMover {
public:
    /// Gives the terrain heights of its own, of 8 bytes each. Cost: O(heights of the terrain).
    explicit HeightMover(Terrain& terrain);

    /// Changes heights, and the terrain's cells and bounds. If copies of the terrain share its heights, they keep the
    /// old ones, for the cost of a copy. Throws as examine_heights(); then nothing has changed. Cost: O(heights), and
    /// the logarithm of the terrain's size; allocates nothing.
    HeightMove move(const std::string& name, Terrain& terrain, const TerrainRectangle& where,
                    std::span<const double> heights);

private:
    static constexpr std::uint32_t side = 8; ///< of a block, in cells or in blocks of the level below

    /// The present cells of a block.
    struct Extent {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        Terrain::Place least{~0u, ~0u}, greatest{0, 0}; ///< the columns and rows that bound them
        std::uint64_t cells = 0;

        void add(const Extent& other);
    };
    struct Level {
        std::uint32_t across, down;
        std::vector<Extent> blocks; ///< row by row
    };
    struct CellRange {
        std::uint32_t x0, y0, x1, y1; ///< the last ones are included
    };
    static Extent extent_of(const Terrain& terrain, std::uint32_t x, std::uint32_t y);
    /// Finds the extents of the blocks over these cells.
    void find_extents(const Terrain& terrain, CellRange cells);

    std::shared_ptr<TerrainHeights> own_; ///< the terrain's
    std::vector<Level> levels_;           ///< the last one has one block
};

} // namespace oncollide
