#pragma once
#include <cstdint>
#include <span>

#include <oncollide/base/aabb.hpp>

namespace oncollide {

constexpr double farthest_coordinate = 1e30; ///< metres; its square fits in a float

/// True if the box is finite and within farthest_coordinate.
inline bool usable(const Aabb& box)
{
    return box.min.cwiseAbs().sum() + box.max.cwiseAbs().sum() < farthest_coordinate; // false for NaN
}
/// Throws Error{bad_data} naming the first body whose box is not usable.
void refuse_unusable(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies);
/// Throws Error{bad_data} naming the first box or segment of a query that is not usable.
void refuse_unusable_queries(std::span<const Aabb> boxes);
void refuse_unusable_queries(std::span<const Segment> segments);

/// The box grown by `margin` on all sides.
inline Aabb grown(const Aabb& box, double margin)
{
    const Eigen::Vector3d by = Eigen::Vector3d::Constant(margin);
    return {box.min - by, box.max + by};
}
/// True if the boxes overlap, each grown by margin / 2.
inline bool overlap(const Aabb& a, const Aabb& b, double margin)
{
    return !(((a.min - b.max).array() > margin).any() || ((b.min - a.max).array() > margin).any());
}

} // namespace oncollide
