#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// A set of triangles, and how it is divided further.
struct GridPart {
    std::uint32_t begin = 0, count = 0; ///< positions in the order of the triangles
    Aabb box;                           ///< bounds of the triangles, relative to the tree's centre
    std::vector<GridPart> parts;        ///< empty, or two to eight parts
};

/// Divides many triangles into parts of a few thousand by the cells of one grid in which their centres lie. It takes
/// two passes over the triangles; halving each part at its median would take one pass per halving. Parts are of similar
/// size where the grid has the resolution, and do not depend on the order of the triangles. Cost: 20 ns per triangle,
/// and 10 bytes per triangle of temporary memory.
///
/// @param triangles  numbers of the triangles; sorted into the order of the parts
/// @param centre     the centre of the tree; boxes are relative to it
/// @param around     a box that holds most of the triangles, relative to the centre
GridPart split_by_grid(const Mesh& mesh, const Eigen::Vector3d& centre, std::span<std::uint32_t> triangles,
                       const Aabb& around);

} // namespace oncollide
