#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/narrowphase/obb/shape_walk.hpp>
#include <oncollide/narrowphase/obb/solid_gap_kernel.hpp>
#include <oncollide/narrowphase/obb/terrain_tree.hpp>

namespace oncollide {

/// How far a convex solid is from the triangles of a mesh or a terrain, the nearest boxes first. One thread's working
/// memory; others may walk the same trees meanwhile.
///
/// BoxWalk has the solid's box against every box. Here a box is bounded along the direction in which the solid's centre
/// sees it nearest, which of a body far away or over flat ground is nearly the distance; and eight cells of a terrain,
/// sixteen triangles, at once by themselves, without boxes. With bounds so close few nodes are opened, so a heap pays.
template <class Tree>
class SolidDistance {
public:
    using Pair = typename ShapeTriangleTests<Tree>::Pair;

    /// As BoxWalk::distance(): what matters still is found, the first of equals.
    /// @param slack  see ConvexPair
    DistanceBounds<Pair> distance(const ShapeTree& shape, Tree& tree, const RelativePose& tree_to_shape, double slack,
                                  double tolerance, double farthest);

    std::uint64_t nodes = 0, triangles = 0; ///< opened; measured

private:
    /// Box `lane` of a node, or what is below it.
    struct Entry {
        float gap;
        std::uint32_t lane;
        typename Tree::Node node;
    };
    class Query;

    std::vector<Entry> heap_;
};

extern template class SolidDistance<ObbTree>;
extern template class SolidDistance<TerrainTree>;

} // namespace oncollide
