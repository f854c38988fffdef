#pragma once
#include <oncollide/narrowphase/walks/box_walk.hpp>
#include <oncollide/narrowphase/walks/shape_tests.hpp>

namespace oncollide {

/// Traversals of a shape as one solid, A, against a mesh, box or hull, and against a terrain; and of a map, A, against
/// a shape.
using ShapeMeshWalk = BoxWalk<const ShapeTree, ObbTree, RoundTests<ShapeTriangleTests<ObbTree>>>;
using ShapeTerrainWalk = BoxWalk<const ShapeTree, TerrainTree, RoundTests<ShapeTriangleTests<TerrainTree>>>;
using MapShapeWalk = BoxWalk<MapTree, const ShapeTree, RoundTests<MapShapeTests>>;
extern template class BoxWalk<const ShapeTree, ObbTree, RoundTests<ShapeTriangleTests<ObbTree>>>;
extern template class BoxWalk<const ShapeTree, TerrainTree, RoundTests<ShapeTriangleTests<TerrainTree>>>;
extern template class BoxWalk<MapTree, const ShapeTree, RoundTests<MapShapeTests>>;

} // namespace oncollide
