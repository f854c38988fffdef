#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// Cuts a simple polygon into triangles with area whose corners are all its corners. The interior is to the left of
/// each loop; one loop is around the others, its holes. Exact for all coordinates. None if the loops do not form such a
/// polygon. Cost: quadratic in the corners. Source: Eberly, "Triangulation by ear clipping", 2002.
/// @param points  positions of all corners, by number
/// @param loops   numbers of the corners
std::optional<std::vector<Triangle>> cut_polygon(std::span<const Eigen::Vector2d> points,
                                                 std::vector<std::vector<std::uint32_t>> loops);

} // namespace oncollide
