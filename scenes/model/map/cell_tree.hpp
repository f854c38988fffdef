#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>

namespace oncollide {

/// Smallest cells from `low` to `high`, excluding `high`.
struct CellBox {
    Eigen::Vector3i low, high;

    explicit CellBox(const MapCell& cell) : low(cell.x, cell.y, cell.z), high(low.array() + cell.side) {}
    CellBox(const Eigen::Vector3i& from, const Eigen::Vector3i& to) : low(from), high(to) {}
    bool empty() const { return (low.array() >= high.array()).any(); }
    bool overlaps(const CellBox& b) const
    {
        return (low.array() < b.high.array()).all() && (b.low.array() < high.array()).all();
    }
    bool contains(const CellBox& b) const
    {
        return (low.array() <= b.low.array()).all() && (b.high.array() <= high.array()).all();
    }
};

class MapChunks;

/// An octree of cells as masks of eight octants: 8 bytes per inner node and none for its leaves. Octants of one state
/// are always joined, so equal cells make equal trees, independent of the order of changes.
///
/// The grid is OctoMap's: cells -32768 to 32767 along each axis.
class CellTree {
public:
    /// An inner node of the octree. An octant that is not inner, occupied or free is unknown.
    struct Node {
        std::uint32_t first = 0;   ///< index of the first of the nodes of its inner octants, which are contiguous
        std::uint8_t inner = 0;    ///< octants that have child octants
        std::uint8_t occupied = 0; ///< octants that are completely occupied
        std::uint8_t free = 0;     ///< octants that are completely free
        std::uint8_t solid = 0;    ///< octants that contain cells that count as occupied
    };
    static constexpr std::int32_t lowest = OccupancyMap::lowest_cell, side = 65536;
    /// Twice the size of the grid, so that a grid of one state is also an octant: octant 0 of top() is the grid.
    static constexpr MapCell top_cube{lowest, lowest, lowest, 2 * side};

    /// All cells are unknown.
    explicit CellTree(bool unknown_is_solid = false);

    const Node& top() const { return top_; }
    bool unknown_is_solid() const { return unknown_ != 0; }
    /// Octants that count as completely occupied.
    std::uint8_t whole(const Node& node) const
    {
        return static_cast<std::uint8_t>(node.occupied | (unknown_ & ~(node.inner | node.free)));
    }
    /// The node of an inner octant.
    const Node& below(const Node& node, unsigned octant) const
    {
        ONCOLLIDE_ASSERT(octant < 8 && (node.inner >> octant & 1));
        const std::uint32_t number = node.first + bits_in(node.inner & ((1u << octant) - 1));
        return chunks_ ? in_chunk(number) : nodes_[number];
    }
    static CellState state(const Node& node, unsigned octant)
    {
        return node.occupied >> octant & 1 ? CellState::occupied
               : node.free >> octant & 1   ? CellState::free
                                           : CellState::unknown;
    }
    /// State of that smallest cell.
    CellState state(const Eigen::Vector3i& cell) const;

    /// Sets all cells of the box, which is within the grid, to one state. Appends the previous states to `before`,
    /// unless it is null. Cost: proportional to the nodes that are added and removed, and their ancestors.
    void set(const CellBox& box, CellState state, std::vector<std::pair<MapCell, CellState>>* before = nullptr);

    /// Calls visit(cube, state) for the leaves that are known, in the octree's order.
    template <class Visit>
    void each_leaf(Visit visit) const
    {
        const MapCell grid = top_cube.octant(0);
        if (top_.inner & 1)
            each_leaf(below(top_, 0), grid, visit);
        else if (state(top_, 0) != CellState::unknown)
            visit(grid, state(top_, 0));
    }
    /// Calls visit(cube) for the largest cubes that count as occupied, in the octree's order, until visit returns
    /// false; then returns false. With wanted(cube): only cubes for which it and all cubes around them return true.
    template <class Wanted, class Visit>
    bool each_solid(Wanted wanted, Visit visit) const
    {
        return each_solid(top_, top_cube, wanted, visit);
    }
    /// Bounds of the occupied cells; if unknown cells count as occupied, bounds of all known cells. Empty if there are
    /// none.
    CellBox bounds() const;

    /// Number of inner nodes and known leaves, as OctoMap counts them.
    std::size_t count() const;
    std::size_t bytes() const;

    /// The chunks of a map in a cooked file, which are read on first use, so that access may throw ChunkFault; null:
    /// the whole map is in memory. A change reads the whole map into memory first.
    MapChunks* chunks() const { return chunks_.get(); }
    CellTree(std::shared_ptr<MapChunks> chunks, const Node& top, bool unknown_is_solid);

    /// The octants of one node, while a tree is built from its leaves up.
    class Octants {
    public:
        Octants() = default;
        Octants(std::uint8_t occupied, std::uint8_t free) { node_.occupied = occupied, node_.free = free; }
        void set(unsigned octant, CellState state);
        void set(unsigned octant, const Node& node); ///< sets a state instead if the whole octant has one

    private:
        friend class CellTree;
        Node node_;
        std::array<Node, 8> below_; ///< by octant; valid for inner octants only
    };
    /// Stores the inner octants contiguously.
    Node close(Octants& octants);
    /// Replaces the whole tree by the node of the grid.
    void set_grid(const Node& grid);
    void set_grid(CellState state);
    void reserve(std::size_t nodes) { nodes_.reserve(nodes); }

    /// Number of set bits of eight; std::popcount would be a function call without -mpopcnt.
    static std::uint32_t bits_in(std::uint32_t bits)
    {
        bits -= bits >> 1 & 0x55;
        bits = (bits & 0x33) + (bits >> 2 & 0x33);
        return (bits + (bits >> 4)) & 0xf;
    }

private:
    const Node& in_chunk(std::uint32_t number) const;
    void take_all();
    Node taken(const Node& node, std::vector<Node>& nodes) const;
    using Before = std::vector<std::pair<MapCell, CellState>>;
    Octants open(const Node& node);
    void take(const Node& node, const MapCell& cube, Before* before);
    Node changed(const Node& node, const MapCell& cube, const CellBox& box, CellState state, Before* before);
    void add_bounds(const Node& node, const MapCell& cube, int axis, bool high, std::int32_t& farthest) const;
    template <class Visit>
    void each_leaf(const Node& node, const MapCell& cube, Visit& visit) const
    {
        for (unsigned k = 0; k < 8; ++k)
            if (node.inner >> k & 1)
                each_leaf(below(node, k), cube.octant(k), visit);
            else if (state(node, k) != CellState::unknown)
                visit(cube.octant(k), state(node, k));
    }
    template <class Wanted, class Visit>
    bool each_solid(const Node& node, const MapCell& cube, Wanted& wanted, Visit& visit) const
    {
        for (unsigned k = 0; k < 8; ++k) {
            const MapCell octant = cube.octant(k);
            if (!(node.solid >> k & 1) || !wanted(octant)) continue;
            if (whole(node) >> k & 1 ? !visit(octant) : !each_solid(below(node, k), octant, wanted, visit))
                return false;
        }
        return true;
    }

    std::vector<Node> nodes_;
    std::shared_ptr<MapChunks> chunks_; ///< holds the nodes of a map in a cooked file
    Node top_;
    std::uint8_t unknown_;               ///< all bits set: unknown cells count as occupied
    std::array<std::uint32_t, 9> spare_; ///< by length: the first free run of nodes; `first` links to the next
    static constexpr std::uint32_t none = ~0u;
};

} // namespace oncollide
