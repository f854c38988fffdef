#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/memory/large_vector.hpp>

namespace oncollide {

/// Orders of boxes that place neighbours near each other.
enum class AabbOrder {
    kd,     ///< split in halves along the longest axis, recursively: tight nodes. O(n log n), 0.2 microseconds per box
    octree, ///< radix sort by Morton code of the centre: looser nodes. O(n), a third of the time
};

constexpr std::uint32_t node_width = 16; ///< boxes per leaf and children per node
constexpr std::uint32_t no_body = ~0u;   ///< the body of slots that are padding

/// Appends `bodies` to `order`, whose size is a multiple of 16: one run per size class, largest first, each in the
/// requested order. All runs except the last are padded to whole nodes of 16 or 256, because a large box among small
/// ones would widen every node above it. Independent of the thread count.
/// @param origin  a point near the boxes: centres are rounded to float relative to it
void append_in_order(AabbOrder kind, std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies,
                     const Eigen::Vector3d& origin, int threads, LargeVector<std::uint32_t>& order);

} // namespace oncollide
