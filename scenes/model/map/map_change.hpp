#pragma once
#include <string>
#include <utility>
#include <vector>

#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide {

/// Throws Error{bad_data}, prefixed with `name`, unless the resolution is from 1e-6 to 1e6 m. Private to scenes.
void check_resolution(const std::string& name, double resolution);

/// The smallest cell that contains the point. Throws Error{usage} for a point outside the grid. Private to scenes.
CellBox cell_at(const OccupancyMap& map, const Eigen::Vector3d& point);

/// A change of a map that is rolled back unless it is committed. Private to scenes.
class MapChange {
public:
    /// @param by_scan  the map's probability octree already contains the change
    explicit MapChange(OccupancyMap& map, bool by_scan = false);
    MapChange(const MapChange&) = delete;
    ~MapChange();

    void set(const CellBox& box, CellState state);
    /// Throws Error{usage} if no cell would remain occupied.
    void commit();

private:
    OccupancyMap& map_;
    MapData& data_;
    const CellBox bounds_before_;
    CellBox bounds_;
    const std::ptrdiff_t known_before_;
    std::vector<std::pair<MapCell, CellState>> before_;
    const bool octree_is_to_know_;
    bool search_ = false; ///< the bounds must be searched for, because cells at them were removed
    bool done_ = false;
};

} // namespace oncollide
