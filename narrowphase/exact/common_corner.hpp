#pragma once
#include <optional>

#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

/// Corners i of A and k of B that are one point, and all that the triangles have in common: they touch there.
struct CommonCorner {
    int a, b;
};

/// Found where a plane through a corner that the two share certainly has the rest of either triangle on one open side:
/// of fans of n triangles around one point, that parts nearly all n^2 pairs. None: nothing is known.
/// Cost: 5 ns without a common corner, 20 with one.
std::optional<CommonCorner> only_common_corner(const TrianglePoints& a, const TrianglePoints& b);

} // namespace oncollide
