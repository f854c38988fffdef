#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/narrowphase/obb/solid_gap_kernel.hpp>
#include <oncollide/narrowphase/obb/terrain_tree.hpp>
#include <oncollide/narrowphase/walks/shape_walk.hpp>

namespace oncollide {

/// The distance of a convex solid from the triangles of a mesh or a terrain, nearest boxes first. One thread's working
/// memory; other threads may traverse the same trees meanwhile.
///
/// BoxWalk tests the solid's box against every box. This class bounds the distance of a box along the direction to its
/// point nearest to the solid's centre; for a distant body, or over flat ground, the bound is nearly the distance.
/// Eight cells of a terrain (sixteen triangles) are tested at once without boxes. With such close bounds few nodes are
/// opened, so a heap pays.
template <class Tree>
class SolidDistance {
public:
    using Pair = typename ShapeTriangleTests<Tree>::Pair;

    /// As BoxWalk::distance(); of equally near pairs it returns the first.
    /// @param slack  see ConvexPair
    DistanceBounds<Pair> distance(const ShapeTree& shape, Tree& tree, const RelativePose& tree_to_shape, double slack,
                                  double tolerance, double cutoff);

    std::uint64_t nodes = 0, triangles = 0; ///< opened; measured

private:
    /// Box `lane` of a node, or the contents of that box.
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
