#include <oncollide/narrowphase/walks/shape_walk.hpp>

#include <oncollide/narrowphase/walks/box_walk_distance.hpp>
#include <oncollide/narrowphase/walks/box_walk_entry.hpp>

namespace oncollide {

static_assert(BoxHierarchy<const ShapeTree> &&
              LeafTests<RoundTests<ShapeTriangleTests<ObbTree>>, const ShapeTree, ObbTree>);
template class BoxWalk<const ShapeTree, ObbTree, RoundTests<ShapeTriangleTests<ObbTree>>>;
template class BoxWalk<const ShapeTree, TerrainTree, RoundTests<ShapeTriangleTests<TerrainTree>>>;
template class BoxWalk<MapTree, const ShapeTree, RoundTests<MapShapeTests>>;

} // namespace oncollide
