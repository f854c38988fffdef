#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/narrowphase/obb/hierarchy.hpp>
#include <oncollide/scenes/cooked/cooked_terrain.hpp>
#include <oncollide/scenes/model/terrain/terrain_access.hpp>

namespace oncollide {

struct TerrainBlocks;
struct TerrainCells;

/// A terrain as a BoxHierarchy: an implicit quadtree that stores the least and the greatest heights of blocks of four
/// by two cells and above; boxes are computed. Read-only, so any number of traversals may share it.
///
/// Level 0 is the cells. A block of level 1 is four by two cells, a block of level 2 two by four blocks of level 1
/// (eight by eight cells), and so on alternately. A node is the eight blocks that would form a block of the next level,
/// but it may begin at any block, so a node fits every position. Below a cell are its two triangles, each in a flat
/// box.
///
/// A terrain in a cooked file has the same boxes. The file's top stores blocks of 64 by 64 cells and above. Smaller
/// blocks are made when a traversal first reaches them, from the chunks of heights, which must agree with the top: all
/// functions that reach them may throw ChunkFault.
class TerrainTree final : public HeldChunks {
public:
    /// Keeps a reference to the terrain. Cost: 6 ns per cell; for a cooked terrain, per block of 64 by 64 cells.
    explicit TerrainTree(const Terrain& terrain);
    ~TerrainTree() override;
    /// Call it after heights of the terrain in memory have changed, while no traversal runs. Bounds of blocks without a
    /// changed height stay as they are, unless the terrain's own bounds have moved far. Cost: 10 ns per cell of the
    /// squares of eight by eight cells that have a changed height, and the blocks above them; allocates nothing.
    void change(const TerrainRectangle& where);
    TerrainTree(const TerrainTree&) = delete;
    TerrainTree& operator=(const TerrainTree&) = delete;

    struct Node {
        std::uint32_t x, y;  ///< position of the first block, counted in blocks of its level
        std::uint32_t level; ///< level of the blocks
        bool whole;          ///< true: one box around all eight
    };
    using Primitive = std::uint32_t; ///< a triangle, by its number in the terrain
    static constexpr Node root{0, 0, ~0u, true};
    static constexpr std::uint32_t triangles = ~0u - 1; ///< the level of a node that holds the two triangles of a cell
    /// The node from which to search, if any, and a lower bound of the distance to everything outside it (as the result
    /// of MapTree::starts).
    struct Entry {
        std::optional<Node> node;
        double gap;
    };
    Entry entry(const Aabb& box) const;
    /// The lowest node below the root that covers all cells in a box, along x and y; it begins where a block of the
    /// next level does. The box must overlap the bounds.
    Node node_around(const Aabb& box) const;

    const Eigen::Vector3d& centre() const { return centre_; }
    double radius() const { return radius_; }
    LaneMasks open(const Node& node, const BoxPlacement* placement, OpenBoxes& boxes) const;
    /// The corners of a node of cells, relative to `from`.
    void open_cells(const Node& node, const Eigen::Vector3d& from, TerrainCells& cells) const;
    /// The blocks of any other node below the root, relative to `from`. The node must begin where a block of the next
    /// level does.
    void open_blocks(const Node& node, const Eigen::Vector3d& from, TerrainBlocks& blocks) const;
    Node child(const Node& node, unsigned lane) const
    {
        if (node.level == root.level) return top_;
        if (node.whole) return {node.x, node.y, node.level, false};
        const Block block = block_of(node, lane);
        if (node.level == 0) return {block.x, block.y, triangles, false};
        const std::uint32_t below = node.level - 1;
        return {block.x * wide(below), block.y * high(below), below, false};
    }
    /// Up to two triangles, by number.
    struct Primitives {
        std::array<std::uint32_t, 2> numbers;
        std::uint32_t count;

        std::uint32_t operator[](std::size_t k) const { return numbers[k]; }
        const std::uint32_t* begin() const { return numbers.data(); }
        const std::uint32_t* end() const { return numbers.data() + count; }
    };
    /// The triangles of a cell, or one of them.
    Primitives primitives(const Node& node, unsigned lane) const
    {
        const bool one = node.level == triangles;
        const Block cell = one ? Block{node.x, node.y} : block_of(node, lane);
        const std::uint32_t first = 2 * (cell.y * terrain_.cells_x() + cell.x) + (one ? lane : 0);
        return {{first, first + 1}, one ? 1u : 2u};
    }
    TrianglePoints points(std::uint32_t triangle) const
    {
        TrianglePoints points;
        const auto corners = terrain_.corners(triangle);
        for (std::size_t k = 0; k < 3; ++k)
            points[k] = TerrainAccess::point(terrain_, corners[k].column, corners[k].row);
        return points;
    }
    const Terrain& terrain() const { return terrain_; }

    std::size_t bytes() const;
    CookedRange range_of_chunk(std::uint32_t x, std::uint32_t y) const; ///< the range of a block of 64 by 64 cells

    void add_held(std::vector<Held>& to) const override;
    void drop(std::uint32_t chunk) override;

    /// Returns the first fault of the whole tree as text; empty: it has none. Assertions and tests call it. Cost:
    /// O(cells); for a cooked terrain, whose chunks are checked when they are read, O(blocks of 64 by 64 cells).
    std::string validate() const;

private:
    /// Heights relative to the centre's, metres, of existing cells; if none exists, low > high.
    struct Range {
        float low, high;
    };
    /// A block lies between two planes, at the heights `low` and `high` over the middle of a whole block.
    struct Slab : Range {
        float slope_x, slope_y;
    };
    /// The bounds of a block of level 3 or above.
    struct Bounds {
        Range range;
        Slab slab;
    };
    /// A block of eight by eight cells: the heights of its eight blocks of level 1 are low + step [lows[k], highs[k]].
    struct Square {
        float low, step;
        std::uint8_t lows[8], highs[8];
        /// The same for planes with these slopes, over the middle of a whole square.
        float slab_low, slab_step, slope_x, slope_y;
        std::uint8_t slab_lows[8], slab_highs[8];
    };
    struct Block {
        std::uint32_t x, y;
    };
    static constexpr float nothing = std::numeric_limits<float>::infinity(); ///< stored as `low` where no cell exists
    static constexpr float range_rounding = 0x1p-20f; ///< error bound of stored heights, as a share of farthest()
    /// Eight by eight squares: a block of level 4.
    static constexpr std::uint32_t part_level = 4;
    struct Part {
        Square squares[64];
        Bounds bounds[8]; ///< bounds of the blocks of level 3
    };

    // A block of the next level is this many blocks wide and high.
    static std::uint32_t wide(std::uint32_t level) { return level % 2 ? 2 : 4; }
    static std::uint32_t high(std::uint32_t level) { return level % 2 ? 4 : 2; }
    /// Sides of a block in cells, as binary logarithms.
    static std::uint32_t log_width(std::uint32_t level) { return level / 2 * 3 + level % 2 * 2; }
    static std::uint32_t log_height(std::uint32_t level) { return level / 2 * 3 + level % 2; }
    static float cells_wide(std::uint32_t level) { return static_cast<float>(std::uint64_t{1} << log_width(level)); }
    static float cells_high(std::uint32_t level) { return static_cast<float>(std::uint64_t{1} << log_height(level)); }
    /// Half of the size of a whole block, metres.
    Eigen::Vector2f half_of_block(std::uint32_t level) const
    {
        return 0.5f *
               terrain_.spacing().cast<float>().cwiseProduct(Eigen::Vector2f(cells_wide(level), cells_high(level)));
    }
    static Block block_of(const Node& node, unsigned lane)
    {
        const std::uint32_t w = wide(node.level);
        return {node.x + lane % w, node.y + lane / w};
    }
    /// The number of blocks of a level along x and y, including partial ones.
    Block blocks(std::uint32_t level) const
    {
        return {((terrain_.cells_x() - 1) >> log_width(level)) + 1,
                ((terrain_.cells_y() - 1) >> log_height(level)) + 1};
    }
    const Square& square(std::uint32_t x, std::uint32_t y) const
    {
        if (TerrainAccess::chunks(terrain_)) return part(x / 8, y / 8).squares[y % 8 * 8 + x % 8];
        return squares_[std::size_t(y) * blocks(2).x + x];
    }
    /// The level is 3 or above.
    const Bounds& bounds(std::uint32_t level, std::uint32_t x, std::uint32_t y) const
    {
        if (level < part_level && TerrainAccess::chunks(terrain_)) return part(x / 2, y / 4).bounds[y % 4 * 2 + x % 2];
        return bounds_[level - 3][std::size_t(y) * blocks(level).x + x];
    }
    Range range(std::uint32_t level, std::uint32_t x, std::uint32_t y) const;
    static Range range_of(const Square& s) { return {s.low, s.low < nothing ? s.low + 255 * s.step : -nothing}; }
    static Slab slab_of(const Square& s)
    {
        return {{s.slab_low, s.slab_low < nothing ? s.slab_low + 255 * s.slab_step : -nothing}, s.slope_x, s.slope_y};
    }
    const Part& part(std::uint32_t x, std::uint32_t y) const
    {
        const std::size_t number = std::size_t(y) * parts_across_ + x;
        const Part* const there = parts_[number].load(std::memory_order_acquire);
        TerrainAccess::chunks(terrain_)->mark(x, y);
        return there ? *there : make_part(x, y);
    }
    struct OpenedBlocks;
    /// @param origin  the origin of the extents' coordinates, in the terrain's frame
    void find_blocks(const Node& node, const Eigen::Vector3d& origin, OpenedBlocks& found) const;
    std::string fault_of_level(std::uint32_t level) const;
    std::string fault_of_cells() const;
    const Part& make_part(std::uint32_t x, std::uint32_t y) const;
    void fill(Part& part, std::uint32_t x, std::uint32_t y) const;
    /// The origin of the boxes' coordinates, in the terrain's frame.
    Eigen::Vector3d origin(const BoxPlacement* placement) const;
    void set_bounds();
    float farthest() const { return std::max(-all_.low, all_.high); } ///< from the zero level of the ranges
    LaneMasks open_cell(const Node& node, const BoxPlacement* placement, OpenBoxes& boxes) const;
    void cell_ranges(const Node& node, Range (&ranges)[8]) const;
    void make_squares();
    struct BlockRange {
        Block first, last; ///< both are included
    };
    static BlockRange blocks_over(std::uint32_t level, const BlockRange& cells);
    void find_squares(const BlockRange& of);
    Square square_of(const float* z, std::size_t width) const;
    static void ranges_of_blocks(const float* z, std::size_t width, bool holes, Range (&of)[8]);
    void add_slabs(Square& square, const float* z, std::size_t width, bool holes) const;
    /// Bounds around the blocks of the level below, given by visit(below, x, y).
    template <class Below>
    Bounds bounds_around(std::uint32_t level, std::uint32_t x, std::uint32_t y, Below below) const;
    template <class Below>
    Slab slab_around(std::uint32_t level, std::uint32_t x, std::uint32_t y, Below below) const;
    void make_level(std::uint32_t level);
    void find_level(std::uint32_t level, const BlockRange& of);
    Bounds bounds_below(std::uint32_t level, std::uint32_t x, std::uint32_t y) const;

    const Terrain& terrain_;
    Eigen::Vector3d centre_; ///< its height is the zero level of the ranges
    double radius_;
    Range all_;                               ///< heights of the terrain's bounds
    Node top_;                                ///< the node that holds all cells
    std::vector<Square> squares_;             ///< blocks of level 2, row by row
    std::vector<std::vector<Bounds>> bounds_; ///< by level from 3, row by row
    std::uint32_t parts_across_ = 0;
    mutable std::vector<std::atomic<Part*>> parts_; ///< parts of a cooked terrain, instead of squares_ and level 3
    mutable std::atomic<std::size_t> held_ = 0;     ///< bytes held by parts_
    mutable OrderedMutex<LockRank::terrain_tree> making_;
};

} // namespace oncollide
