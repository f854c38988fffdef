#pragma once
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/rays/segment_walk.hpp>

namespace oncollide {

/// Tests segments against models. One thread's working memory.
class SegmentQuery {
public:
    /// True if meets() covers models of this kind.
    static bool covers(Kind kind) { return kind != Kind::round && kind != Kind::half_space; }

    /// True if the segment has a point in common with the model: with a triangle, or with a cell of a map, which is
    /// solid. Exact for the segment's coordinates in the model's frame. Throws ChunkFault.
    ///
    /// The OBB tree of a mesh must exist. If a box or a hull has none, its triangles are all tested.
    bool meets(Model& model, const Segment& segment);

private:
    template <class Tree, class Meets>
    bool any(SegmentWalk<Tree>& walk, Tree& tree, const Segment& segment, Meets meets);

    SegmentWalk<ObbTree> meshes_;
    SegmentWalk<TerrainTree> terrains_;
    SegmentWalk<MapTree> maps_;
};

} // namespace oncollide
