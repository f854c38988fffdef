#pragma once
#include <memory>
#include <string>

#include <oncollide/scenes/model/occupancy_map.hpp>

namespace oncollide {

/// Of a map's smallest cells, m.
constexpr double least_resolution = 1e-6, most_resolution = 1e6;

/// The occupied leaves of a tree. Private to scenes. Throws Error{bad_data} naming `name` when there are none.
OccupancyMap map_of(const std::string& name, std::shared_ptr<const octomap::OcTree> tree);

} // namespace oncollide
