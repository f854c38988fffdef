#pragma once
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/inside/point_location.hpp>
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/rays/segment_walk.hpp>

namespace oncollide {

/// Tests segments against models. One thread's working memory.
class SegmentQuery {
public:
    /// True if meets() covers models of this kind.
    static bool covers(Kind kind) { return kind != Kind::round && kind != Kind::half_space; }

    /// True if meets() needs the model's OBB tree.
    static bool needs_tree(Kind kind) { return kind == Kind::mesh; }

    /// Colliding if meets(), or, with the kind `enclosed`, if the segment is inside the model; else separate, with a
    /// bound of 0.
    /// @param solid  the inside of a closed mesh belongs to the mesh
    Finding decide(Model& model, const Segment& segment, bool solid);

    /// True if the segment has a point in common with the model: with a triangle, or with a cell of a map, which is
    /// solid. Exact for the segment's coordinates in the model's frame. Throws ChunkFault.
    ///
    /// If a box or a hull has no OBB tree, its triangles are all tested.
    bool meets(Model& model, const Segment& segment);

private:
    template <class Tree, class Meets>
    bool any(SegmentWalk<Tree>& walk, Tree& tree, const Segment& segment, Meets meets);

    SegmentWalk<ObbTree> meshes_;
    SegmentWalk<TerrainTree> terrains_;
    SegmentWalk<MapTree> maps_;
    PointLocator locator_;
};

} // namespace oncollide
