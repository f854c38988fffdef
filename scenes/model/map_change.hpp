#pragma once
#include <string>
#include <utility>
#include <vector>

#include <oncollide/scenes/model/occupancy_map.hpp>

namespace oncollide {

/// Throws Error{bad_data}, prefixed with `name`, unless the resolution is from 1e-6 to 1e6 m. Private to scenes.
void check_resolution(const std::string& name, double resolution);

/// A change of a map that is rolled back unless it is committed. Private to scenes.
class MapChange {
public:
    /// @param by_scan  the map's probability octree already contains the change
    explicit MapChange(OccupancyMap& map, bool by_scan = false)
        : map_(map), bounds_before_(map.cell_bounds_), bounds_(map.cell_bounds_),
          known_before_(std::ssize(map.since_scan_)), octree_is_to_know_(!by_scan && (map.given_ || map.scanned_))
    {
    }
    MapChange(const MapChange&) = delete;
    ~MapChange();

    void set(const CellBox& box, CellState state);
    /// Throws Error{usage} if no cell would remain occupied.
    void commit();

private:
    OccupancyMap& map_;
    const CellBox bounds_before_;
    CellBox bounds_;
    const std::ptrdiff_t known_before_;
    std::vector<std::pair<MapCell, CellState>> before_;
    const bool octree_is_to_know_;
    bool search_ = false; ///< the bounds must be searched for: cells at them were removed
    bool done_ = false;
};

} // namespace oncollide
