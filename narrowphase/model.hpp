#pragma once
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include <oncollide/base/memory/once.hpp>
#include <oncollide/base/simd/prefetch.hpp>
#include <oncollide/broadphase/bounds/pose_bounds.hpp>
#include <oncollide/narrowphase/fcl/exact_fcl.hpp>
#include <oncollide/narrowphase/hulls/inner_spheres.hpp>
#include <oncollide/narrowphase/hulls/outer_hull.hpp>
#include <oncollide/narrowphase/inside/parts.hpp>
#include <oncollide/narrowphase/kind.hpp>
#include <oncollide/narrowphase/obb/map_tree.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/narrowphase/obb/shape_tree.hpp>
#include <oncollide/narrowphase/obb/terrain_tree.hpp>
#include <oncollide/narrowphase/rays/tree/ray_tree.hpp>
#include <oncollide/narrowphase/shapes/convex.hpp>
#include <oncollide/narrowphase/shapes/hull_faces.hpp>
#include <oncollide/narrowphase/spheres/ocst.hpp>
#include <oncollide/narrowphase/spheres/surface.hpp>
#include <oncollide/scenes/model/box_corners.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide {

struct MeshLinks;

/// Owns all data derived from a geometry. Each item is computed once, when it is first needed, and stays at its
/// address, shared by all bodies, queries and threads.
///
/// Const members may be called from many threads at once. Traversals grow the trees; the owners of the budgets
/// (SphereForest, ObbResidency) make and drop them, never while a traversal runs.
class Model {
public:
    /// Shares the geometry. Cost: computing its bounds only.
    /// @param number  identifies the model and its sphere-tree to backends
    explicit Model(std::shared_ptr<const Geometry> geometry, std::uint32_t number = 0);
    ~Model() { drop_obb_tree(); } // it refers to members that are destroyed before it
    Model(const Model&) = delete;
    Model& operator=(const Model&) = delete;

    Kind kind() const { return kind_; }
    const Geometry& geometry() const { return *geometry_; }
    /// Null if the geometry is not a mesh. For a cooked mesh this reads and keeps the whole file, which may throw
    /// ChunkFault; use cooked() where it suffices.
    const Mesh* mesh() const { return cooked() ? &whole() : as<Mesh>(); }
    /// The mesh in a cooked file; null for other geometries.
    const CookedMesh* cooked() const
    {
        const auto* mesh = as<std::shared_ptr<const CookedMesh>>();
        return mesh ? mesh->get() : nullptr;
    }
    /// The file from which tests read parts of the geometry on demand; null: none.
    const CookedFile* file() const { return file_; }
    /// Makes this model hold its own chunks of the file of a map or a terrain; they count in `budget`. Call it before
    /// any other member.
    void read_on_demand(ChunkBudget& budget);
    /// Reads the whole file. Throws ChunkFault.
    void read_all() const;
    /// The chunks that this model holds of a map's or a terrain's file; null: none.
    HeldChunks* held_grid() const;
    bool is_mesh() const { return kind_ == Kind::mesh; }
    bool is_bounded_shape() const { return kind_ == Kind::polytope || kind_ == Kind::round; } ///< convex() is there
    const Shape* shape() const { return as<Shape>(); }
    const OccupancyMap* map() const { return as<OccupancyMap>(); }
    const Terrain* terrain() const { return as<Terrain>(); }

    /// World AABBs at any pose.
    PoseBounds& bounds() { return bounds_; }
    const PoseBounds& bounds() const { return bounds_; }

    /// The convex mesh around a shape. The model must be a shape.
    const BoundingMesh& bounding_mesh() const;
    /// How far the surface that trees are built over may lie outside the geometry (m); 0 unless it is a shape.
    double covering_error() const { return shape() ? bounding_mesh().covering_error : 0.0; }
    /// True for a mesh, a box or a hull: exact triangle tests decide it.
    bool has_triangles() const { return kind_ == Kind::mesh || kind_ == Kind::polytope; }
    /// True if the OBB tree exists, or the model needs none.
    bool has_obb_tree() const { return obb_tree_ || !has_triangles(); }
    /// True if a sphere-tree can represent the model.
    bool has_sphere_tree() const { return kind_ != Kind::terrain && kind_ != Kind::half_space; }
    /// Distance of the farthest point from the origin of the geometry's frame; 0 for a half-space.
    double reach() const { return kind_ == Kind::half_space ? 0 : bounds_.reach(); }
    /// The shape for tests without trees. The model must be a shape other than a half-space.
    const Convex& convex() const;
    /// The faces of a hull. The model must be a hull.
    const HullFaces& hull_faces() const;
    /// The shape as one primitive for traversals. The model must be a shape other than a half-space.
    const ShapeTree& shape_tree() const;
    /// The triangles that OBB trees are built over: the mesh, or the surface of a box or a hull; null: there are none.
    const Mesh* surface_mesh() const { return !has_triangles() ? nullptr : shape() ? &polytope() : mesh(); }
    std::size_t triangles() const { return cooked() ? cooked()->triangles() : surface_mesh()->triangles.size(); }
    std::size_t vertices() const { return cooked() ? cooked()->vertices() : surface_mesh()->vertices.size(); }
    /// The octree of a map. The model must be a map.
    MapTree& cells() const;
    /// The quadtree of a terrain. The model must be a terrain.
    TerrainTree& heights() const;
    std::size_t grid_bytes() const; ///< memory of the quadtree, and of the chunks held of a map's file
    /// The cell around the geometry, or around the bounding mesh of a shape.
    RootCell root_cell() const;
    /// The surface for occlusion backends, which own it. Not for terrains. Cost: 10 ns per primitive.
    Surface surface(const RootCell& root) const;

    /// True for a mesh in which every edge is shared by two triangles that traverse it in opposite directions.
    bool closed() const;
    bool is_open_mesh() const { return is_mesh() && !closed(); }
    /// True if surface_mesh() has an inside: a closed mesh, a box or a hull.
    bool has_inside() const { return kind_ == Kind::polytope || closed(); }
    /// The neighbours of each triangle of surface_mesh(), or of a round shape's bounding mesh. Memory: 12 bytes per
    /// triangle and 4 per vertex.
    const MeshLinks& links() const;
    /// Memory of links() and of the mesh's joined faces with their tree; 0 until links() is called.
    std::size_t links_bytes() const;
    /// The OBB tree of a round shape's bounding mesh.
    ObbTree& bounding_tree() const;
    /// Points of each connected part; empty for a map.
    std::span<const PartPoints> parts() const;
    /// Calls visit(part) for every part that may be in a box, possibly for others too, until it returns true. Returns
    /// whether it did.
    /// @param into  moves the box into the geometry's frame
    template <class Visit>
    bool any_part(const Aabb& box, const RelativePose& into, Visit visit) const;
    /// The model for FCL, used with exact = fcl.
    const FclModel& fcl() const;

    /// Call before each traversal against another mesh. Builds the outer hull, and later the inner spheres, once there
    /// were enough traversals to repay the cost. Returns true if it built something. Not thread-safe.
    /// @param near  the last traversal did not separate the two meshes, so their hulls would not have either
    bool prepare_solids(bool near);
    /// True if nothing is left to prepare.
    bool has_solids() const { return (hull_ && (inner_spheres_ || !is_mesh())) || no_solids_ || !has_triangles(); }
    /// The convex solid around surface_mesh(); null: not built.
    const OuterHull* hull() const { return hull_.get(); }
    /// The spheres inside a mesh; null: not built.
    const InnerSpheres* inner_spheres() const { return inner_spheres_.get(); }

    std::uint32_t number() const { return number_; }
    Ocst* spheres() const { return spheres_.get(); }      ///< the sphere-tree; null until a test reaches it
    ObbTree* obb_tree() const { return obb_tree_.get(); } ///< the tree of surface_mesh(); null until a test reaches it
    /// The tree for segments, over the OBB tree; null: the mesh is small, deforms or is cooked, or a budget limits
    /// trees.
    RayTree* ray_tree() const;
    /// Why a cooked mesh can have no OBB tree; empty: it can.
    const std::string& unreadable() const { return unreadable_; }
    /// Records that a pair needs the OBB tree in this frame.
    void need_obb_tree(std::uint32_t frame)
    {
        if (obb_tree_needed() != frame) obb_tree_needed_.store(frame, std::memory_order_relaxed);
    }
    /// The last frame in which a pair needed the OBB tree.
    std::uint32_t obb_tree_needed() const { return obb_tree_needed_.load(std::memory_order_relaxed); }

    /// Returns the first fault of the trees as text; empty: they have none. Assertions call it while no test runs.
    /// @param most  leaves out trees of more nodes or cells
    std::string validate(std::size_t most) const;
    /// Call it after vertices [first, first + count) of the mesh have moved, while no test runs. Drops the data derived
    /// from the old vertices, except the OBB tree, which follows them. The model must be a mesh in memory.
    /// @param radius2  as VertexMove::radius2
    void deform(std::uint32_t first, std::uint32_t count, double radius2);
    /// The same for heights of a terrain in memory: its quadtree follows them.
    void change_heights(const TerrainRectangle& where);

    /// Prefetches the members that a pair reads first.
    void prefetch() const { oncollide::prefetch(this, 192); }

private:
    friend class SphereForest; // sets spheres_
    friend class ObbResidency; // sets obb_tree_ and unreadable_
    /// Makes the OBB tree. The tree counts in the totals unless it has a budget.
    /// @param budget  null: a cooked mesh is read as a whole
    void make_obb_tree(ChunkBudget* budget, BoxTotals& totals);
    void drop_obb_tree() { ray_tree_.reset(), obb_tree_.reset(); }
    /// Does not read the geometry itself: in a large world the geometries lie scattered in memory.
    template <class Data>
    const Data* as() const
    {
        return index_ == index_of<Data>(&geometry_->data) ? static_cast<const Data*>(data_) : nullptr;
    }
    template <class Data, class... All>
    static constexpr std::size_t index_of(const std::variant<All...>*)
    {
        std::size_t index = 0;
        ((!std::is_same_v<Data, All> && ++index) && ...);
        return index;
    }
    const Mesh& polytope() const;
    const Mesh& whole() const;

    // prefetch() loads these members, which are read first.
    const std::uint32_t number_;
    std::atomic<std::uint32_t> obb_tree_needed_ = 0;
    std::unique_ptr<Ocst> spheres_;
    std::unique_ptr<ObbTree> obb_tree_;
    Once<std::unique_ptr<RayTree>> ray_tree_;
    bool has_budget_ = false; ///< a budget limits trees
    std::string unreadable_;
    std::shared_ptr<const Geometry> geometry_;
    const Kind kind_;
    const std::uint8_t index_; ///< the kind of the data, as an index in the geometry
    const void* data_;         ///< the data of that kind: the geometry's, or this model's own
    const CookedFile* file_;
    std::unique_ptr<OuterHull> hull_;
    std::unique_ptr<InnerSpheres> inner_spheres_;
    PoseBounds bounds_;
    std::optional<OccupancyMap> own_map_;
    std::optional<Terrain> own_terrain_;
    Once<BoundingMesh> bounding_mesh_;
    Once<Mesh> polytope_, whole_;
    Once<Convex> convex_;
    Once<HullFaces> hull_faces_;
    Once<ShapeTree> shape_tree_;
    Once<std::unique_ptr<MapTree>> cells_;
    Once<std::unique_ptr<TerrainTree>> heights_;
    Once<std::unique_ptr<ObbTree>> bounding_tree_;
    Once<std::shared_ptr<const MeshLinks>> links_; // MeshLinks is incomplete here
    Once<bool> closed_;
    Once<std::vector<PartPoints>> parts_;
    Once<std::shared_ptr<const FclModel>> fcl_;
    std::uint64_t walks_ = 0; ///< traversals that the hull or the inner spheres might have saved
    bool no_solids_ = false;  ///< the file cannot be read, or the vertices move
};

/// The AABB of a moved box, rounded outward.
inline Aabb box_moved(const Aabb& box, const RelativePose& into)
{
    Aabb around;
    for (unsigned k = 0; k < 8; ++k) around.add(into(corner_of(box, k)));
    const double slack = 0x1p-16 * (around.max - around.min).maxCoeff() + 0x1p-40 * into.translation.stableNorm();
    around.min.array() -= slack, around.max.array() += slack;
    return around;
}

template <class Visit>
bool Model::any_part(const Aabb& box, const RelativePose& into, Visit visit) const
{
    if (!map()) return std::ranges::any_of(parts(), visit);
    return !MapAccess::each_cell(*map(), box_moved(box, into), [&](const MapCell& cell) {
        PartPoints points;
        points.fill(MapAccess::box(*map(), cell).centre());
        return !visit(points);
    });
}

} // namespace oncollide
