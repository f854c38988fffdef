#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/narrowphase/boxes/hierarchy.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>

namespace oncollide {

/// A cube of an occupancy map's grid: its least corner and its side, in smallest cells.
struct MapCell {
    std::int32_t x, y, z, side;

    /// The corners as the map's own boxes have them: neighbours share their faces exactly.
    Aabb box(double resolution) const
    {
        return {{x * resolution, y * resolution, z * resolution},
                {(x + side) * resolution, (y + side) * resolution, (z + side) * resolution}};
    }
    MapCell octant(unsigned k) const
    {
        const std::int32_t half = side / 2;
        return {x + (k & 1 ? half : 0), y + (k & 2 ? half : 0), z + (k & 4 ? half : 0), half};
    }
};

/// The octree of an occupancy map as a BoxHierarchy: two masks and the place of its first inner child for each inner
/// node, 8 bytes; boxes are computed. Reads only, so any number of walks may share it.
class MapTree {
public:
    /// Cost: 100 ns a cell when they are in the octree's order, as OctoMap's are.
    explicit MapTree(const OccupancyMap& map);

    struct Node {
        std::uint32_t index;
        MapCell cube;
    };
    using Primitive = MapCell;
    static constexpr Node root{~0u, {}};
    /// Where to start for what is in the box, in the map's frame: a node that holds one box around all cells there, and
    /// how far the other cells are from the box at least, metres. No node: there are none there.
    struct Entry {
        std::optional<Node> node;
        double gap;
    };
    Entry entry(const Aabb& box) const;

    const Eigen::Vector3d& centre() const { return centre_; }
    double radius() const { return radius_; }
    double resolution() const { return resolution_; }
    LaneMasks open(const Node& node, const BoxPlacement* placement, OpenBoxes& boxes) const;
    Node child(const Node& node, unsigned lane) const;
    std::array<MapCell, 1> primitives(const Node& node, unsigned lane) const
    {
        return {node.cube.octant(octant_of(nodes_[node.index], lane))};
    }

    /// visit(cell) for occupied cells that the box touches, while it returns true. False when it did not.
    template <class Visit>
    bool each_cell(const Aabb& box, Visit visit) const
    {
        return each_cell(top_, box, visit);
    }

    std::size_t bytes() const { return nodes_.capacity() * sizeof(Inner); }

private:
    static constexpr std::uint32_t whole = 1u << 31; ///< marks a node that stands for itself, as one box
    /// An inner node of the octree. Octant k is along x, y and z by the bits of k.
    struct Inner {
        std::uint32_t first; ///< of its inner children, which lie side by side
        std::uint8_t parted; ///< octants that are inner nodes
        std::uint8_t full;   ///< occupied as a whole
    };
    /// Of eight; portable code would call a function for it.
    static std::uint32_t bits_in(std::uint32_t bits)
    {
        bits -= bits >> 1 & 0x55;
        bits = (bits & 0x33) + (bits >> 2 & 0x33);
        return (bits + (bits >> 4)) & 0xf;
    }
    static unsigned octant_of(const Inner& node, unsigned lane)
    {
        unsigned all = node.parted | node.full;
        while (lane-- > 0) all &= all - 1;
        return static_cast<unsigned>(__builtin_ctz(all));
    }
    Node below(const Node& node, unsigned octant) const
    {
        const Inner& inner = nodes_[node.index];
        return {inner.first + bits_in(inner.parted & ((1u << octant) - 1)), node.cube.octant(octant)};
    }
    Node forked(Node node) const;
    template <class Visit>
    bool each_cell(const Node& node, const Aabb& box, Visit& visit) const
    {
        const Inner inner = nodes_[node.index];
        for (unsigned k = 0; k < 8; ++k) {
            if (!((inner.parted | inner.full) >> k & 1)) continue;
            const MapCell cube = node.cube.octant(k);
            if (!cube.box(resolution_).overlaps(box)) continue;
            if (inner.full >> k & 1 ? !visit(cube) : !each_cell(below(node, k), box, visit)) return false;
        }
        return true;
    }
    void build(std::uint32_t index, const MapCell& cube, const MapCell* begin, const MapCell* end);

    double resolution_;
    Aabb bounds_;
    Eigen::Vector3d centre_;
    double radius_;
    std::vector<Inner> nodes_;
    Node top_; ///< the deepest node that holds all cells
};

} // namespace oncollide
