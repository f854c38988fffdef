#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/error.hpp>

namespace octomap {
class OcTree;
}

namespace oncollide {

struct MapData;

/// A cube of an occupancy map's grid: its least corner and its side, in smallest cells.
struct MapCell {
    std::int32_t x, y, z, side;

    /// One of the eight octants: the bits of k select the half along x, y and z.
    MapCell octant(unsigned k) const
    {
        const std::int32_t half = side / 2;
        return {x + (k & 1 ? half : 0), y + (k & 2 ? half : 0), z + (k & 4 ? half : 0), half};
    }
    friend auto operator<=>(const MapCell&, const MapCell&) = default;
};

/// The state of a cell of an occupancy map.
enum class CellState : std::uint8_t { unknown, free, occupied };

/// An occupancy map: solid axis-aligned cells in the map's own frame. At least one cell is occupied.
///
/// Cell (i, j, k), -32768 to 32767 each, is the closed box from (i, j, k) to (i + 1, j + 1, k + 1) resolutions.
/// Neighbours share their faces exactly. An octree holds the states of the cells: 8 bytes per inner node, none for its
/// leaves. A map that was moved from may only be assigned to or destroyed.
class ONCOLLIDE_API OccupancyMap {
public:
    static constexpr std::int32_t lowest_cell = -32768, highest_cell = 32767;

    OccupancyMap(const OccupancyMap&);
    OccupancyMap(OccupancyMap&&) noexcept;
    OccupancyMap& operator=(const OccupancyMap&);
    OccupancyMap& operator=(OccupancyMap&&) noexcept;
    ~OccupancyMap();

    double resolution() const { return resolution_; } ///< side of the smallest cell, metres
    /// Bounds of the occupied cells, not of the address space; if unknown cells count as occupied, bounds of all known
    /// cells.
    const Aabb& bounds() const { return bounds_; }
    /// The box of a cube of cells, clipped to the bounds.
    Aabb box(const MapCell& cube) const;
    /// Calls visit(cube) for the occupied cubes that touch the box, in the octree's order, until visit returns false;
    /// then returns false.
    bool each_cell(const Aabb& around, const std::function<bool(const MapCell& cube)>& visit) const;
    /// Calls visit(box) for the largest occupied cubes, in the octree's order.
    void each_box(const std::function<void(const Aabb& box)>& visit) const;
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
    void keep(std::shared_ptr<const octomap::OcTree> tree);

    std::size_t bytes() const; ///< without the octree of probabilities

private:
    friend struct MapAccess;
    OccupancyMap(std::unique_ptr<MapData> data, double resolution);

    double resolution_;
    Aabb bounds_;
    std::unique_ptr<MapData> data_;
};

/// A map of these cubes of cells; other cells are unknown. A cell in both lists is free.
/// @param name  names the map in errors
/// @param unknown_is_occupied  unknown cells count as occupied, within the box around all known cells
/// Throws Error{usage} for a cube that is not within the grid, Error{bad_data} if no cell is occupied or the resolution
/// is not from 1e-6 to 1e6 m. Cost: 200 ns per cube.
ONCOLLIDE_API OccupancyMap make_occupancy_map(const std::string& name, double resolution,
                                              std::span<const MapCell> occupied, std::span<const MapCell> free = {},
                                              bool unknown_is_occupied = false);

/// Converts an octree in memory, at its threshold of occupancy; its inner nodes may be out of date. The second overload
/// keeps the octree, which must not change any more: scans continue from its probabilities. Throws Error{bad_data} if
/// no cell is occupied, the resolution is not from 1e-6 to 1e6 m, an occupancy is not finite, or the tree is null.
ONCOLLIDE_API OccupancyMap make_occupancy_map(const octomap::OcTree& tree, bool unknown_is_occupied = false);
ONCOLLIDE_API OccupancyMap make_occupancy_map(std::shared_ptr<const octomap::OcTree> tree,
                                              bool unknown_is_occupied = false);

/// An octree of the map's known cells, all as certain as OctoMap allows; also of the unknown cells if they count as
/// occupied. Cost: 100 ns and 20 to 80 bytes per node.
ONCOLLIDE_API std::shared_ptr<octomap::OcTree> make_octree(const OccupancyMap& map);

} // namespace oncollide
