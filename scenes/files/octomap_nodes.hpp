#pragma once
#include <string>
#include <string_view>

#include <oncollide/scenes/model/cell_tree.hpp>

namespace oncollide {

struct OctomapNodes {
    double resolution;
    std::size_t begin; ///< the byte at which the nodes start
    CellTree cells;
};

/// The cells of a `.bt` file. Throws Error{bad_data}, with `name` in front, unless the bytes are one whole tree.
/// Nothing is allocated because the header says so. Private to scenes.
OctomapNodes read_binary_octomap(const std::string& name, std::string_view bytes, bool unknown_is_occupied);

/// The same of a `.ot` file, in which the cells of this probability and above are occupied.
OctomapNodes read_full_octomap(const std::string& name, std::string_view bytes, bool unknown_is_occupied,
                               double occupancy_threshold);

} // namespace oncollide
