#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/large_vector.hpp>

namespace oncollide {

/// Ways to put boxes in an order in which neighbours are near each other.
enum class BoxOrder {
    kd,     ///< halves along the longest axis, again and again: tight nodes. O(n log n), 0.2 microseconds per box
    octree, ///< by the path to the centre's cell in an octree (Morton code), radix sorted: looser nodes. O(n), a third
};

constexpr std::uint32_t node_width = 16; ///< boxes per leaf and children per node
constexpr std::uint32_t no_body = ~0u;   ///< at places of padding

/// Appends `bodies` to `order`, whose size is a multiple of 16: runs of bodies of one size class, the largest first,
/// each in the order requested and all but the last padded to whole nodes of 16 or 256. Large boxes among small ones
/// would widen every node that they are in. The same for any number of threads.
/// @param origin  near the boxes: centres are rounded to float relative to it
void append_in_order(BoxOrder kind, std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies,
                     const Eigen::Vector3d& origin, int threads, LargeVector<std::uint32_t>& order);

} // namespace oncollide
