#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/scenes/model/cell_tree.hpp>

namespace octomap {
class OcTree;
}

namespace oncollide {

/// An occupancy map: solid axis-aligned cells in the map's own frame. At least one cell is occupied.
///
/// Cell (i, j, k), -32768 to 32767 each, is the closed box from (i, j, k) to (i + 1, j + 1, k + 1) resolutions.
/// Neighbours share their faces exactly. The states of the cells are in a CellTree: 8 bytes per inner node of the
/// octree, none for its leaves.
class OccupancyMap {
public:
    /// Throws Error{bad_data}, prefixed with `name`, if no cell is occupied or the resolution is not from 1e-6 to 1e6
    /// metres.
    OccupancyMap(const std::string& name, CellTree cells, double resolution);

    const CellTree& cells() const { return cells_; }
    double resolution() const { return resolution_; } ///< side of the smallest cell, metres
    /// Bounds of the occupied cells, not of the address space; if unknown cells count as occupied too, of the known
    /// cells.
    const Aabb& bounds() const { return bounds_; }
    const CellBox& cell_bounds() const { return cell_bounds_; } ///< bounds() in cells
    /// The box of a cube of cells, clipped to the bounds.
    Aabb box(const MapCell& cube) const;
    /// Cells that touch the box; may include cells that nearly touch it.
    CellBox cells_touching(const Aabb& box) const;
    /// Calls visit(cube) for the occupied cubes that touch the box, in the octree's order, until visit returns false;
    /// then returns false.
    template <class Visit>
    bool each_cell(const Aabb& box_around, Visit visit) const
    {
        const CellBox cells = cells_touching(box_around),
                      near{cells.low.cwiseMax(cell_bounds_.low), cells.high.cwiseMin(cell_bounds_.high)};
        const auto wanted = [&](const MapCell& cube) { return near.overlaps(CellBox(cube)); };
        return cells_.each_solid(wanted, [&](const MapCell& cube) {
            const Aabb there = box(cube);
            const bool touches = (there.min.array() < there.max.array()).all() && there.overlaps(box_around);
            return !touches || visit(cube);
        });
    }
    /// Calls visit(box) for the largest occupied cubes, in the octree's order.
    template <class Visit>
    void each_box(Visit visit) const
    {
        each_cell(bounds_, [&](const MapCell& cube) { return visit(box(cube)), true; });
    }
    std::size_t count() const; ///< number of the boxes of each_box()

    // --- Changes. Points and boxes are in the map's frame, metres. Throws Error{usage}, without any change, for
    // numbers that are not finite, for points outside the grid, and if no cell would remain occupied. Cost:
    // proportional to the octree's nodes that are added and removed; if cells at the bounds are removed, the bounds are
    // recomputed: at worst 10 ns per node.
    /// Sets the cells that contain the points.
    void set(std::span<const Eigen::Vector3d> points, CellState state);
    /// Sets the cells of the grid whose centres are in the box.
    void set(const Aabb& box, CellState state);
    /// Copies the states of the same cells from another map of the same resolution.
    void replace(const Aabb& box, const OccupancyMap& by);
    /// Inserts a scan in the same way as octomap::OcTree::insertPointCloud(): lowers the probability of cells that rays
    /// pass and raises it for cells in which they end. From then on the map keeps an octree with the cells'
    /// probabilities, initially make_octree() or the octree that the map was made from; cells that were set since the
    /// last scan count as certain.
    /// @param max_range  metres; longer rays are cut there and hit nothing. Negative: no limit
    void insert_scan(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& origin, double max_range = -1);

    /// Scans continue from the probabilities of this octree, which has the same cells and must not change any more.
    void keep(std::shared_ptr<const octomap::OcTree> tree) { given_ = std::move(tree); }

    std::size_t bytes() const { return cells_.bytes(); } ///< without the octree of probabilities

private:
    friend class MapChange;
    friend class MapChunks;
    OccupancyMap(CellTree cells, double resolution, const CellBox& bounds)
        : cells_(std::move(cells)), resolution_(resolution), cell_bounds_(bounds)
    {
        set_bounds(bounds);
    }

    bool empty() const;
    void set_bounds(const CellBox& cells);
    CellBox cells_in(const Aabb& box) const;
    CellBox cell_at(const Eigen::Vector3d& point) const;

    CellTree cells_;
    double resolution_;
    CellBox cell_bounds_; ///< cells that bounds() encloses
    Aabb bounds_;
    std::shared_ptr<const octomap::OcTree> given_;          ///< with the probabilities of the cells; may be null
    std::shared_ptr<octomap::OcTree> scanned_;              ///< replaces given_ after the first scan
    std::vector<std::pair<CellBox, CellState>> since_scan_; ///< changes that the octree of probabilities does not
                                                            ///< contain yet
};

/// Converts an octree in memory, at its threshold of occupancy; its inner nodes may be out of date. The second overload
/// keeps the octree, which must not change any more: scans continue from its probabilities. Throws Error{bad_data} if
/// no cell is occupied, the resolution is not from 1e-6 to 1e6 m, an occupancy is not finite, or the tree is null.
/// @param unknown_is_occupied  unknown cells count as occupied, within the box around all known cells
OccupancyMap make_occupancy_map(const octomap::OcTree& tree, bool unknown_is_occupied = false);
OccupancyMap make_occupancy_map(std::shared_ptr<const octomap::OcTree> tree, bool unknown_is_occupied = false);

/// An octree of the map's known cells, all as certain as OctoMap allows; also of the unknown cells if they count as
/// occupied. Cost: 100 ns and 20 to 80 bytes per node.
std::shared_ptr<octomap::OcTree> make_octree(const OccupancyMap& map);

} // namespace oncollide
