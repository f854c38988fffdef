#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include <oncollide/base/aabb.hpp>

namespace octomap {
class OcTree;
}

namespace oncollide {

/// An OctoMap environment: solid axis-aligned cells in the map's own frame.
struct OccupancyMap {
    std::vector<Aabb> cells; ///< occupied leaves, pruned ones as one large cell; order of OctoMap's leaf iterator
    Aabb bounds;             ///< of the occupied cells, not of the address space
    double resolution = 0;   ///< side of the smallest cell, metres
    std::shared_ptr<const octomap::OcTree> tree; ///< the map itself, for the exact level
};

/// The map of an octree in memory, at its thresholds of occupancy. Copies the tree. Throws Error{bad_data} when nothing
/// is occupied, the resolution is not from 1e-6 to 1e6 m, or an occupancy is not finite.
OccupancyMap make_occupancy_map(const octomap::OcTree& tree);
/// The same, sharing the tree, which must not change any more. Throws also when there is none, and when an inner node
/// is free though a cell in it is occupied (after lazy updates: call updateInnerOccupancy() first).
OccupancyMap make_occupancy_map(std::shared_ptr<const octomap::OcTree> tree);

/// Reads `.bt` and `.ot` files. Throws Error{no_input} or Error{bad_data} (empty, truncated, wrong kind, nothing
/// occupied).
OccupancyMap load_octomap(const std::filesystem::path& path);

/// A building of about `rooms` x `rooms` rooms with furniture at the given resolution (m); for use without a file.
OccupancyMap make_building_map(int rooms, double resolution, std::uint64_t seed);

/// Writes the map as a `.bt` file (temporary name, then renamed). Throws Error{cannot_write}.
void save_octomap(const OccupancyMap& map, const std::filesystem::path& path);

} // namespace oncollide
