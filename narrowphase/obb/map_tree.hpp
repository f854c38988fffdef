#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/narrowphase/obb/hierarchy.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide {

/// The octree of an occupancy map as a BoxHierarchy, read in place: boxes are computed. Read-only, so any number of
/// traversals may share it.
class MapTree {
public:
    /// Keeps a reference to the map, which must not change. Cost: O(1).
    explicit MapTree(const OccupancyMap& map);

    struct Node {
        CellTree::Node octants;
        MapCell cube; ///< side 0: the root
    };
    using Primitive = MapCell;
    static constexpr Node root{{}, {0, 0, 0, 0}};
    /// Writes nodes that together hold all cells in a box of the map's frame. Their boxes are no larger than a box of
    /// the squared radius `size`, as far down as the tree extends. Returns a lower bound of the distance from the box
    /// to all other cells, metres.
    double starts(const Aabb& box, double size, std::vector<Node>& nodes) const;
    struct Octant {
        Node of; ///< the node that it is an octant of
        unsigned number;
        bool whole;
    };
    /// The smallest octant that holds all solid cells at a box, or is whole; nothing if there are none.
    std::optional<Octant> octant_around(const Aabb& box) const;

    const OccupancyMap& map() const { return map_; }
    const Eigen::Vector3d& centre() const { return centre_; }
    double radius() const { return radius_; }
    LaneMasks open(const Node& node, const BoxPlacement* placement, OpenBoxes& boxes) const;
    Node child(const Node& node, unsigned lane) const;
    /// Octants that are not empty. Unknown octants count only within the bounds.
    unsigned solid(const Node& node) const
    {
        return cells_.unknown_is_solid() ? solid_in_bounds(node) : node.octants.solid;
    }
    /// Octants that count as completely occupied.
    unsigned whole(const Node& node) const { return cells_.whole(node.octants); }
    std::array<MapCell, 1> primitives(const Node& node, unsigned lane) const { return {node.cube.octant(lane)}; }

private:
    unsigned solid_in_bounds(const Node& node) const;
    Node below(const Node& node, unsigned octant) const
    {
        return {cells_.below(node.octants, octant), node.cube.octant(octant)};
    }
    Node forked(Node node) const;

    const OccupancyMap& map_;
    const CellTree& cells_;
    Eigen::Vector3d centre_;
    double radius_;
};

} // namespace oncollide
