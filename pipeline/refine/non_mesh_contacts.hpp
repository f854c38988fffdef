#pragma once
#include <vector>

#include <oncollide/narrowphase/obb/map_walk.hpp>
#include <oncollide/narrowphase/obb/shape_walk.hpp>
#include <oncollide/pipeline/contacts.hpp>
#include <oncollide/pipeline/refine/pair_refiner.hpp>

namespace oncollide {

/// Contacts of pairs in which a shape or a map takes part; both are solid. One thread's working memory.
///
/// Exact where NonMeshPairs is: of cells, boxes, hulls and triangles every two with a common point are found, for the one
/// body's coordinates as moved into the other's frame in double; of round shapes what rounding hides is found too, as
/// near.
class NonMeshContacts {
public:
    /// Appends, sorted by (a, b), each pair of parts once. The trees of meshes must be there. Cost: that of the exact
    /// level, and half a microsecond to two for each contact.
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
