#pragma once
#include <optional>

#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

/// Corners i of A and k of B that are the same point, and the triangles have no other point in common: they touch
/// there.
struct CommonCorner {
    int a, b;
};

/// True if two corners of A are also corners of B. Then the triangles do not cross: they lie in one plane, or their
/// planes meet in the line through these corners.
bool have_common_edge(const TrianglePoints& a, const TrianglePoints& b);

/// Returns a common corner if some plane through it certainly has the rest of the two triangles on opposite open sides;
/// for fans of n triangles around one point, that decides nearly all n^2 pairs. Returns none if nothing is known. Cost:
/// 5 ns without a common corner, 20 with one.
std::optional<CommonCorner> only_common_corner(const TrianglePoints& a, const TrianglePoints& b);

} // namespace oncollide
