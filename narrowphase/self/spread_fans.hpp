#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// For each vertex: 1 if it is certain that the triangles at it lie around it without overlap, so that two of them
/// share only this vertex, or only the edge from it to another vertex that both have. Decides nearly all vertices that
/// triangles surround at angles below 90 degrees, in one test for all pairs of these triangles. Cost: 20 ns per
/// triangle.
std::vector<std::uint8_t> spread_fans(const Mesh& mesh, int threads);

} // namespace oncollide
