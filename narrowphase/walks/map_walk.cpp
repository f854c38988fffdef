#include <oncollide/narrowphase/walks/map_walk.hpp>

#include <oncollide/narrowphase/walks/box_walk_distance.hpp>
#include <oncollide/narrowphase/walks/box_walk_entry.hpp>

namespace oncollide {

static_assert(BoxHierarchy<const MapTree> && LeafTests<CellTests<PlacedTriangles>, const MapTree, ObbTree>);
template class BoxWalk<MapTree, ObbTree, CellTests<PlacedTriangles>>;
template class BoxWalk<MapTree, MapTree, CellTests<PlacedCells>>;
template class BoxWalk<MapTree, TerrainTree, CellTests<PlacedTerrain>>;

} // namespace oncollide
