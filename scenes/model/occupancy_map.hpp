#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
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

/// An OctoMap environment: solid axis-aligned cells in the map's own frame. At least one cell is occupied.
///
/// Cell (i, j, k), -32768 to 32767 each, is the closed box from (i, j, k) to (i + 1, j + 1, k + 1) resolutions.
/// Neighbours share their faces exactly. What is known of the cells is a CellTree: 8 bytes an inner node of the octree,
/// nothing for its leaves.
class OccupancyMap {
public:
    /// Throws Error{bad_data}, with `name` in front, when no cell is occupied or the resolution is not from 1e-6 to 1e6
    /// metres.
    OccupancyMap(const std::string& name, CellTree cells, double resolution);

    const CellTree& cells() const { return cells_; }
    double resolution() const { return resolution_; } ///< side of the smallest cell, metres
    /// Of the occupied cells, not of the address space; if unknown ones count too, of the known cells.
    const Aabb& bounds() const { return bounds_; }
    const CellBox& cell_bounds() const { return cell_bounds_; } ///< the same, in cells
    /// The box of a cube of cells, cut to the bounds.
    Aabb box(const MapCell& cube) const
    {
        const Eigen::Array3d low(cube.x, cube.y, cube.z);
        return {(low * resolution_).max(bounds_.min.array()),
                ((low + cube.side) * resolution_).min(bounds_.max.array())};
    }
    /// Cells that touch the box, and perhaps some that are all but there.
    CellBox cells_touching(const Aabb& box) const
    {
        const auto cell = [](const Eigen::Array3d& at) -> Eigen::Vector3i {
            return at.max(-4.0 * CellTree::side).min(4.0 * CellTree::side).cast<int>();
        };
        const double scale = 1 / resolution_;
        return {cell((box.min.array() * scale - 1e-9).floor()), cell((box.max.array() * scale + 1e-9).ceil())};
    }
    /// visit(cube) for the occupied cubes that touch the box, in the octree's order, while it returns true. False when
    /// it did not.
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
    /// visit(box) for the occupied cubes, as large as can be, in the octree's order.
    template <class Visit>
    void each_box(Visit visit) const
    {
        each_cell(bounds_, [&](const MapCell& cube) { return visit(box(cube)), true; });
    }
    std::size_t count() const; ///< of those boxes

    // --- Changes. Points and boxes are in the map's frame, metres. Throws Error{usage}, and has changed nothing, for
    // numbers that are not finite, for points beyond the grid, and where no cell would be left occupied. Cost: of the
    // octree's nodes that come and go; where cells at the bounds go, the bounds are searched for: at worst 10 ns a
    // node.
    /// The cells that the points are in.
    void set(std::span<const Eigen::Vector3d> points, CellState state);
    /// The cells of the grid whose middles are in the box.
    void set(const Aabb& box, CellState state);
    /// The same cells become what they are in another map, of the same resolution.
    void replace(const Aabb& box, const OccupancyMap& by);
    /// What a scan sees, as octomap::OcTree::insertPointCloud() takes it in: cells that rays pass become less probable,
    /// those where they end more. Keeps an octree with the cells' probabilities from then on, at first that of
    /// make_octree() or the one that the map came with; what was set since the last scan counts as certain.
    /// @param max_range  metres; longer rays are cut there and hit nothing. Negative: none is too long
    void insert_scan(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& origin, double max_range = -1);

    /// Scans go on from the probabilities of this octree, which is of the same cells and must not change any more.
    void keep(std::shared_ptr<const octomap::OcTree> tree) { given_ = std::move(tree); }

    std::size_t bytes() const { return cells_.bytes(); } ///< without an octree

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
    CellBox cell_bounds_; ///< of what bounds() is around
    Aabb bounds_;
    std::shared_ptr<const octomap::OcTree> given_;          ///< with the probabilities of the cells; may be null
    std::shared_ptr<octomap::OcTree> scanned_;              ///< after scans, in its place
    std::vector<std::pair<CellBox, CellState>> since_scan_; ///< what was set that the octree does not know of
};

/// The map of an octree in memory, at its threshold of occupancy; it may have been updated lazily. The second keeps the
/// octree, which must not change any more: scans go on from its probabilities. Throws Error{bad_data} when nothing is
/// occupied, the resolution is not from 1e-6 to 1e6 m, an occupancy is not finite, or there is no tree.
/// @param unknown_is_occupied  cells that nothing is known of count as occupied, within the box around all known ones
OccupancyMap make_occupancy_map(const octomap::OcTree& tree, bool unknown_is_occupied = false);
OccupancyMap make_occupancy_map(std::shared_ptr<const octomap::OcTree> tree, bool unknown_is_occupied = false);

/// An octree of the map's known cells, all as certain as OctoMap lets them be; where unknown cells count as occupied,
/// of these too. Cost: 100 ns and 20 to 80 bytes a node.
std::shared_ptr<octomap::OcTree> make_octree(const OccupancyMap& map);

/// How a file becomes a map.
struct MapOptions {
    bool unknown_is_occupied = false; ///< as for make_occupancy_map()
    /// From which probability on a cell is occupied, above 0 and below 1; by default 0.5, as OctoMap has it. Only for
    /// `.ot` files: a `.bt` file knows no probabilities.
    std::optional<double> occupancy_threshold{};
};

/// Reads `.bt` and `.ot` files. Throws Error{no_input}, Error{bad_data} (empty, truncated, wrong kind, nothing
/// occupied) or Error{usage} for a threshold that makes no sense. A `.bt` file whose root has no children is what
/// OctoMap takes it for: the whole grid is occupied. The probabilities of a `.ot` file are kept, for scans to go on
/// from. Cost: a `.bt` file 10 ns a byte and 4 bytes a byte.
OccupancyMap load_octomap(const std::filesystem::path& path, const MapOptions& options = {});

/// A building of about `rooms` x `rooms` rooms with furniture at the given resolution (m); for use without a file.
OccupancyMap make_building_map(int rooms, double resolution, std::uint64_t seed);

/// Writes what is known of the map's cells as a `.bt` file (temporary name, then renamed). Throws Error{cannot_write}.
void save_octomap(const OccupancyMap& map, const std::filesystem::path& path);

} // namespace oncollide
