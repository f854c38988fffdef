#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <oncollide/scenes/model/map/cell_tree.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>

namespace oncollide {

/// The content of an OccupancyMap.
struct MapData {
    CellTree cells;
    CellBox bounds;                                          ///< the cells that OccupancyMap::bounds() encloses
    std::shared_ptr<const octomap::OcTree> given{};          ///< with the probabilities of the cells; may be null
    std::shared_ptr<octomap::OcTree> scanned{};              ///< replaces `given` after the first scan
    std::vector<std::pair<CellBox, CellState>> since_scan{}; ///< changes that the octree of probabilities does not
                                                             ///< contain yet
};

/// An OccupancyMap's cells, and its arithmetic inline, for the library's own loops, as TerrainAccess.
struct MapAccess {
    /// Throws Error{bad_data}, prefixed with `name`, if no cell is occupied or the resolution is not from 1e-6 to 1e6
    /// metres.
    static OccupancyMap make(const std::string& name, CellTree cells, double resolution);
    /// A map that is known to be valid.
    static OccupancyMap make(CellTree cells, double resolution, const CellBox& bounds);

    static const CellTree& cells(const OccupancyMap& map) { return map.data_->cells; }
    static const CellBox& cell_bounds(const OccupancyMap& map) { return map.data_->bounds; }
    static MapData& data(OccupancyMap& map) { return *map.data_; }
    static void set_bounds(OccupancyMap& map, const CellBox& cells);
    static bool empty(const OccupancyMap& map);

    /// OccupancyMap::box()
    static Aabb box(const OccupancyMap& map, const MapCell& cube)
    {
        const Eigen::Array3d low(cube.x, cube.y, cube.z);
        return {(low * map.resolution_).max(map.bounds_.min.array()),
                ((low + cube.side) * map.resolution_).min(map.bounds_.max.array())};
    }
    /// Cells that touch the box; may include cells that nearly touch it.
    static CellBox cells_touching(const OccupancyMap& map, const Aabb& box);
    /// OccupancyMap::each_cell()
    template <class Visit>
    static bool each_cell(const OccupancyMap& map, const Aabb& around, Visit visit)
    {
        const CellBox cells = cells_touching(map, around), &all = cell_bounds(map),
                      near{cells.low.cwiseMax(all.low), cells.high.cwiseMin(all.high)};
        const auto wanted = [&](const MapCell& cube) { return near.overlaps(CellBox(cube)); };
        return MapAccess::cells(map).each_solid(wanted, [&](const MapCell& cube) {
            const Aabb there = box(map, cube);
            const bool touches = (there.min.array() < there.max.array()).all() && there.overlaps(around);
            return !touches || visit(cube);
        });
    }
};

} // namespace oncollide
