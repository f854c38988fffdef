#pragma once
#include <optional>
#include <span>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide::oracle {

/// Winding number of closed surfaces around a point; nullopt if it is on a surface.
/// @param triangle  the triangle of a number below `count`
/// Cost: some nanoseconds per triangle, and 0.5 to 20 microseconds for triangles near the ray.
std::optional<int> winding(std::size_t count, FunctionRef<TrianglePoints(std::size_t)> triangle,
                           const Eigen::Vector3d& point);
std::optional<int> winding(std::span<const TrianglePoints> surface, const Eigen::Vector3d& point);

} // namespace oncollide::oracle
