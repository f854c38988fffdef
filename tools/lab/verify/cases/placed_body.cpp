#include "verify/cases/placed_body.hpp"

namespace oncollide::tools {

OccupancyMap one_cell(double side)
{
    const MapCell cell{0, 0, 0, 1};
    return make_occupancy_map("cell", side, {&cell, 1});
}

} // namespace oncollide::tools
