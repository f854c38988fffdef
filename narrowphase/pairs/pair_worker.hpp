#pragma once
#include <memory>
#include <vector>

#include <oncollide/narrowphase/inside/point_location.hpp>
#include <oncollide/narrowphase/inside/shared_inside.hpp>
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/pairs/pair_task.hpp>
#include <oncollide/narrowphase/pairs/penetration_depth.hpp>
#include <oncollide/narrowphase/walks/map_walk.hpp>
#include <oncollide/narrowphase/walks/shape_walk.hpp>
#include <oncollide/narrowphase/walks/solid_distance.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>

namespace oncollide {

// How a test of a pair takes a body.
namespace operand {

/// The cells of a map.
struct Cells {
    static MapTree& tree(Model& model) { return model.cells(); }
    static double error(const Model&) { return 0; } ///< error bound of its coordinates, metres
};
/// The triangles of a terrain.
struct Heights {
    static TerrainTree& tree(Model& model) { return model.heights(); }
    static double error(const Model& model) { return model.terrain()->error(); }
};
/// The triangles of a mesh. Its OBB tree must exist.
struct Triangles {
    static ObbTree& tree(Model& model) { return *model.obb_tree(); }
    static double error(const Model&) { return 0; }
};
/// The surface of a box or a hull. Its OBB tree must exist.
struct Polytope : Triangles {};
/// A bounded shape as one solid.
struct Solid {
    static const ShapeTree& tree(Model& model) { return model.shape_tree(); }
    static double error(const Model&) { return 0; }
};

/// A half-space.
struct Plane {};

/// Hulls with more points are measured by the triangles of their surface: a solid hull scans all its points for each
/// direction.
constexpr std::uint32_t most_points = 1024;

} // namespace operand

struct ManifoldMemory;

/// One thread's working memory for the tests of all kinds of pairs: a walk for each two hierarchies that are compared.
class PairWorker {
public:
    /// The traversal of two hierarchies of triangles.
    Traversal& traversal(const ObbTree&, const ObbTree&) { return meshes_; }
    TraversalOf<TerrainTree, ObbTree>& traversal(const TerrainTree&, const ObbTree&) { return terrain_first_; }
    TraversalOf<ObbTree, TerrainTree>& traversal(const ObbTree&, const TerrainTree&) { return terrain_second_; }
    TraversalOf<TerrainTree, TerrainTree>& traversal(const TerrainTree&, const TerrainTree&) { return terrains_; }

    /// The walk of two hierarchies.
    template <class A, class B>
    auto& walk(const A& a, const B& b)
    {
        return traversal(a, b).walk();
    }
    MapMeshWalk& walk(const MapTree&, const ObbTree&) { return map_mesh_; }
    MapTerrainWalk& walk(const MapTree&, const TerrainTree&) { return map_terrain_; }
    MapMapWalk& walk(const MapTree&, const MapTree&) { return map_map_; }
    MapShapeWalk& walk(const MapTree&, const ShapeTree&) { return map_shape_; }
    ShapeMeshWalk& walk(const ShapeTree&, const ObbTree&) { return shape_mesh_; }
    ShapeTerrainWalk& walk(const ShapeTree&, const TerrainTree&) { return shape_terrain_; }

    SolidDistance<ObbTree>& solid_distance(const ObbTree&) { return mesh_distance_; }
    SolidDistance<TerrainTree>& solid_distance(const TerrainTree&) { return terrain_distance_; }

    PointLocator locator;
    SharedInside inside;
    PenetrationDepth penetration;
    std::vector<TrianglePair> pairs;
    std::vector<Contact> meetings;
    std::shared_ptr<ManifoldMemory> manifold_memory; ///< made by the first manifold

    /// Counts of the walks; see Traversal::Counts. Primitives of all kinds count as triangles.
    Traversal::Counts counts() const;
    void reset_counts();

private:
    static void each_traversal(auto& worker, auto visit)
    {
        visit(worker.meshes_), visit(worker.terrain_first_), visit(worker.terrain_second_), visit(worker.terrains_);
    }
    static void each_walk(auto& worker, auto visit)
    {
        visit(worker.map_mesh_), visit(worker.map_terrain_), visit(worker.map_map_), visit(worker.map_shape_);
        visit(worker.shape_mesh_), visit(worker.shape_terrain_);
    }

    Traversal meshes_;
    TraversalOf<TerrainTree, ObbTree> terrain_first_;
    TraversalOf<ObbTree, TerrainTree> terrain_second_;
    TraversalOf<TerrainTree, TerrainTree> terrains_;
    MapMeshWalk map_mesh_;
    MapTerrainWalk map_terrain_;
    MapMapWalk map_map_;
    MapShapeWalk map_shape_;
    ShapeMeshWalk shape_mesh_;
    ShapeTerrainWalk shape_terrain_;
    SolidDistance<ObbTree> mesh_distance_;
    SolidDistance<TerrainTree> terrain_distance_;
};

} // namespace oncollide
