#pragma once
#include <oncollide/scenes/model/occupancy_map.hpp>

namespace oncollide {

/// OccupancyMap::box() inline, for the library's own loops, as TerrainAccess.
inline Aabb box_in(const OccupancyMap& map, const MapCell& cube)
{
    const Eigen::Array3d low(cube.x, cube.y, cube.z);
    return {(low * map.resolution()).max(map.bounds().min.array()),
            ((low + cube.side) * map.resolution()).min(map.bounds().max.array())};
}

} // namespace oncollide
