#pragma once
#include <string>
#include <string_view>

#include <oncollide/scenes/model/map/cell_tree.hpp>

namespace oncollide {

struct OctomapNodes {
    double resolution;
    std::size_t begin; ///< the byte at which the nodes start
    CellTree cells;
};

/// The cells of a `.bt` file. Throws Error{bad_data}, prefixed with `name`, unless the bytes are one whole tree.
/// Allocations do not depend on counts in the header. Private to scenes.
OctomapNodes read_binary_octomap(const std::string& name, std::string_view bytes, bool unknown_is_occupied);

/// The same for a `.ot` file, whose cells of at least this probability are occupied. A ColorOcTree loses its colours:
/// its nodes in `bytes` become nodes of an OcTree.
OctomapNodes read_full_octomap(const std::string& name, std::string& bytes, bool unknown_is_occupied,
                               double occupancy_threshold);

} // namespace oncollide
