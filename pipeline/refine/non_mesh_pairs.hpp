#pragma once
#include <oncollide/narrowphase/obb/map_walk.hpp>
#include <oncollide/narrowphase/obb/shape_walk.hpp>
#include <oncollide/narrowphase/obb/solid_distance.hpp>
#include <oncollide/narrowphase/inside/point_location.hpp>
#include <oncollide/pipeline/contacts.hpp>
#include <oncollide/pipeline/refine/pair_refiner.hpp>
#include <oncollide/pipeline/refine/triangle_walks.hpp>

namespace oncollide {

/// A mesh, or a terrain with exact heights.
bool is_surface(const Model& model);
/// Can the triangles of the mesh, of the terrain or of the surface of the shape tell exactly? So it is of boxes and
/// hulls.
bool is_polytope(const Model& model);

/// Are trees walked for the pair? Not for two shapes, unless kinds of contact are wanted of polytopes.
bool needs_trees(const Model& a, const Model& b, bool kinds);

/// The exact level of pairs in which a round shape, a half-space, a map or a terrain with heights that are off takes
/// part, with certificates of its own: colliding where points of both are certainly one, separate where a gap is
/// certain. What rounding hides (2^-47 of the bodies' sizes and distance, where a sphere or a capsule is turned or
/// another round shape takes part), and heights that are off, stay `within`.
/// Shapes and cells are solid. One thread's working memory.
class NonMeshPairs {
public:
    /// The trees of both models must be there.
    /// @param memory  what met last, but of two maps, is tested first; null: nothing is remembered
    RefineResult exact(const RefineContext& context, const PairTask& task, PairMemory* memory);

    /// Any pair but two surfaces: within clearance + tolerance (metres), or separate.
    RefineResult near(const RefineContext& context, const PairTask& task, PairMemory* memory, double tolerance);

    /// Of bodies that do not meet, surfaces too: separate beyond the clearance, or near.
    RefineResult within_clearance(const RefineContext& context, const PairTask& task);

    /// Of any pair but two surfaces, as World::distance() says; but of a box or a hull, where it encloses a map's cells
    /// or a part of a mesh, it may be that of its surface. Of bodies farther apart than `farthest` the upper bound is
    /// infinite.
    Distance distance(const PairTask& task, double tolerance, double farthest);

    /// Does a shape with a volume, one of the two, enclose a part of the other? Their surfaces are apart.
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
