#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// A corner of a triangle, 0 to 2, and the fan that it belongs to.
struct FanCorner {
    std::uint32_t triangle;
    std::uint8_t corner;
    std::uint32_t fan;
};

/// The corners flagged, by triangle. Triangles around a vertex that follow each other over edges from there are one
/// fan.
/// @param flags  by triangle: bit i for its corner i
/// Cost: n log n of the corners flagged, and a look at each triangle.
std::vector<FanCorner> fans_of(const Mesh& mesh, std::span<const std::uint8_t> flags);

} // namespace oncollide
