#pragma once
#include <oncollide/narrowphase/walks/box_walk.hpp>
#include <oncollide/narrowphase/walks/cell_tests.hpp>

namespace oncollide {

/// Traversals of a map, A, against a mesh or the core of a shape, against another map, and against a terrain.
using MapMeshWalk = BoxWalk<MapTree, ObbTree, CellTests<PlacedTriangles>>;
using MapMapWalk = BoxWalk<MapTree, MapTree, CellTests<PlacedCells>>;
using MapTerrainWalk = BoxWalk<MapTree, TerrainTree, CellTests<PlacedTerrain>>;
extern template class BoxWalk<MapTree, ObbTree, CellTests<PlacedTriangles>>;
extern template class BoxWalk<MapTree, MapTree, CellTests<PlacedCells>>;
extern template class BoxWalk<MapTree, TerrainTree, CellTests<PlacedTerrain>>;

} // namespace oncollide
