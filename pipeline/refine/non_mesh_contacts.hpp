#pragma once
#include <vector>

#include <oncollide/narrowphase/walks/map_walk.hpp>
#include <oncollide/narrowphase/walks/shape_walk.hpp>
#include <oncollide/pipeline/refine/pair_refiner.hpp>
#include <oncollide/pipeline/results.hpp>

namespace oncollide {

/// Contacts of pairs with at least one shape or map; both are solid. One thread's working memory.
///
/// Exact where NonMeshPairs is: all pairs of cells, boxes, hulls and triangles with a common point are found, for one
/// body's coordinates transformed into the other's frame in double. Contacts of round shapes that rounding cannot
/// decide are reported as `near`.
class NonMeshContacts {
public:
    /// Appends contacts sorted by (a, b), each pair of parts once. The OBB trees of meshes must exist. Cost: the cost
    /// of the exact level, plus half a microsecond to two per contact.
    void find(const PairTask& task, std::vector<Contact>& contacts);

private:
    MapMeshWalk map_mesh_;
    MapTerrainWalk map_terrain_;
    MapMapWalk map_map_;
    ShapeMeshWalk shape_mesh_;
    ShapeTerrainWalk shape_terrain_;
    MapShapeWalk map_shape_;
};

} // namespace oncollide
