#pragma once
#include <oncollide/narrowphase/inside/point_location.hpp>
#include <oncollide/narrowphase/walks/map_walk.hpp>
#include <oncollide/narrowphase/walks/shape_walk.hpp>
#include <oncollide/narrowphase/walks/solid_distance.hpp>
#include <oncollide/pipeline/refine/pair_refiner.hpp>
#include <oncollide/pipeline/refine/triangle_walks.hpp>
#include <oncollide/pipeline/results.hpp>

namespace oncollide {

/// True for a mesh, or a terrain with exact heights.
bool is_surface(const Model& model);
/// True if exact triangle tests decide this model: meshes, exact terrains, boxes and hulls.
bool is_polytope(const Model& model);

/// True if the pair needs trees. Two shapes need none, unless they are polytopes and kinds of contact are requested.
bool needs_trees(const Model& a, const Model& b, bool kinds);

/// The exact level for pairs with a round shape, a half-space, a map or a terrain with inexact heights. Certified:
/// colliding if a common point is certain, separate if a gap is certain. Pairs stay `within` if rounding (2^-47 of the
/// bodies' sizes and distance, if a sphere or a capsule is rotated or another round shape takes part) or the error of
/// heights leaves both possible.
/// Shapes and cells are solid. One thread's working memory.
class NonMeshPairs {
public:
    /// The trees of both models must exist.
    /// @param memory  witness, tested first (except for two maps) and updated; null: no witness
    Finding exact(const RefineContext& context, const PairTask& task, PairMemory* memory);

    /// Any pair except two surfaces: within clearance + tolerance (metres), or separate.
    Finding near(const RefineContext& context, const PairTask& task, PairMemory* memory, double tolerance);

    /// For bodies that do not meet, including surfaces: separate beyond the clearance, or near.
    Finding within_clearance(const RefineContext& context, const PairTask& task);

    /// For any pair except two surfaces, as World::distance(). Exception: for a box or a hull that encloses a map's
    /// cells or a part of a mesh, it may be the distance to its surface. Beyond `farthest`, the upper bound is
    /// infinite.
    Distance distance(const PairTask& task, double tolerance, double farthest);

    /// True if a shape of the pair encloses a part of the other body. Requires that their surfaces do not meet.
    bool shape_holds(const PairTask& task);

    struct Counts {
        std::uint64_t box_rows = 0, primitives = 0, hints_held = 0;
    };
    Counts counts();
    void reset_counts();

private:
    auto with_walk(const PairTask& task, auto work);
    bool shape_apart_from_large(const PairTask& task);
    std::optional<Distance> solid_distance(const PairTask& task, double tolerance, double farthest);

    TriangleWalks triangles_;
    MapMeshWalk map_mesh_;
    MapTerrainWalk map_terrain_;
    MapMapWalk map_map_;
    ShapeMeshWalk shape_mesh_;
    ShapeTerrainWalk shape_terrain_;
    MapShapeWalk map_shape_;
    SolidDistance<ObbTree> mesh_distance_;
    SolidDistance<TerrainTree> terrain_distance_;
    PointLocator locator_;
};

} // namespace oncollide
