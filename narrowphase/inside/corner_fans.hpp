#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// A corner of a triangle, 0 to 2, and its fan.
struct FanCorner {
    std::uint32_t triangle;
    std::uint8_t corner;
    std::uint32_t fan;
};

/// The flagged corners, by triangle. Triangles around a vertex that are connected through edges at the vertex form one
/// fan. Cost: n log n in the number of flagged corners, and a pass over the triangles.
/// @param flags  by triangle: bit i for its corner i
std::vector<FanCorner> fans_of(const Mesh& mesh, std::span<const std::uint8_t> flags);

} // namespace oncollide
