#pragma once
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include <oncollide/base/prefetch.hpp>
#include <oncollide/broadphase/pose_bounds.hpp>
#include <oncollide/narrowphase/obb/map_tree.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/narrowphase/obb/terrain_tree.hpp>
#include <oncollide/narrowphase/exact/exact_fcl.hpp>
#include <oncollide/narrowphase/hulls/inner_spheres.hpp>
#include <oncollide/narrowphase/hulls/outer_hull.hpp>
#include <oncollide/narrowphase/inside/parts.hpp>
#include <oncollide/narrowphase/shapes/convex.hpp>
#include <oncollide/narrowphase/shapes/polytope_surface.hpp>
#include <oncollide/narrowphase/shapes/shape_tree.hpp>
#include <oncollide/narrowphase/spheres/ocst.hpp>
#include <oncollide/narrowphase/spheres/surface.hpp>
#include <oncollide/scenes/model/box_corners.hpp>

namespace oncollide {

/// The one owner of everything that is derived from a geometry: each thing is worked out once, when it is first needed,
/// and stays at its address, shared by all bodies, queries and threads.
///
/// What is const here is safe to call from many threads at once. The trees are grown by walks, and made and dropped by
/// whoever holds the budgets (ModelStore), never while walks are under way.
class Model {
public:
    /// Shares the geometry. Cost: its bounds, no more.
    explicit Model(std::shared_ptr<const Geometry> geometry);
    ~Model() { obb_tree.reset(); } // what they are of goes later
    Model(const Model&) = delete;
    Model& operator=(const Model&) = delete;

    const Geometry& geometry() const { return *geometry_; }
    /// Null: it is no mesh. Of a cooked one all of its file is read and kept, unless cooked() serves as well; then it
    /// throws ChunkFault.
    const Mesh* mesh() const { return cooked() ? &whole() : as<Mesh>(); }
    /// Of a mesh in a cooked file; else null.
    const CookedMesh* cooked() const
    {
        const auto* mesh = as<std::shared_ptr<const CookedMesh>>();
        return mesh ? mesh->get() : nullptr;
    }
    /// The file that parts of it are read from where tests need them; null: none.
    const CookedFile* file() const { return file_; }
    /// Of a map or a terrain in a file: what is read of it is this model's own from now on, and counts here. Before
    /// anything else is asked of it.
    void read_on_demand(ChunkBudget& budget);
    /// Reads all of the file, for what needs all of it. Throws ChunkFault.
    void read_all() const;
    /// What it holds of a map's or a terrain's file; null: nothing.
    HeldChunks* held_grid() const;
    bool is_mesh() const { return as<Mesh>() || cooked(); }
    const Shape* shape() const { return as<Shape>(); }
    const OccupancyMap* map() const { return as<OccupancyMap>(); }
    const Terrain* terrain() const { return as<Terrain>(); }

    /// World boxes at any pose.
    PoseBounds& bounds() { return bounds_; }
    const PoseBounds& bounds() const { return bounds_; }

    /// The convex mesh around a shape. The model must be a shape.
    const BoundingMesh& bounding_mesh() const;
    /// How far the surface that trees are built over may lie outside the geometry (m): 0 but for shapes.
    double covering_error() const { return shape() ? bounding_mesh().covering_error : 0.0; }
    bool is_half_space() const { return shape() && std::holds_alternative<HalfSpace>(*shape()); }
    /// Is it a mesh, a box or a hull, whose triangles tell exactly?
    bool has_triangles() const { return is_mesh() || (shape() && is_polytope(*shape())); }
    /// The shape as tests without trees take it. The model must be a shape, and no half-space.
    const Convex& convex() const;
    /// The shape as one primitive for walks. The model must be a shape, and no half-space.
    const ShapeTree& shape_tree() const;
    /// What trees of oriented boxes are built over: the mesh, or the surface of a box or a hull; null: there is none.
    const Mesh* surface_mesh() const { return !has_triangles() ? nullptr : shape() ? &polytope() : mesh(); }
    std::size_t triangles() const { return cooked() ? cooked()->triangles() : surface_mesh()->triangles.size(); }
    std::size_t vertices() const { return cooked() ? cooked()->vertices() : surface_mesh()->vertices.size(); }
    /// Makes its tree of oriented boxes, which counts in the totals unless it has a budget.
    /// @param budget  null: a cooked mesh is read as a whole
    void make_obb_tree(ChunkBudget* budget, BoxTotals& totals);
    /// The octree of a map. The model must be a map.
    MapTree& cells() const;
    /// The quadtree of a terrain. The model must be a terrain.
    TerrainTree& heights() const;
    std::size_t grid_bytes() const; ///< of the quadtree, and of what is held of a map's file
    /// Around the geometry, or around the bounding mesh of a shape.
    RootCell root_cell() const;
    /// What occlusion backends see, but not of a terrain. Not kept: backends own it. Cost: 10 ns a primitive.
    Surface surface(const RootCell& root) const;

    /// Is it a mesh in which every edge is shared by two triangles that run along it in opposite directions?
    bool closed() const;
    /// Has surface_mesh() an inside? That of a closed mesh, of a box or a hull.
    bool has_inside() const { return shape() ? is_polytope(*shape()) : closed(); }
    /// Connected parts, each by points of it; none of a map.
    std::span<const PartPoints> parts() const;
    /// visit(part) until it returns true, for all parts that may be in a box, at least. Returns whether it did.
    /// @param into  moves the box into the geometry's frame
    template <class Visit>
    bool any_part(const Aabb& box, const RelativePose& into, Visit visit) const;
    /// FCL's model, for exact = fcl.
    const FclModel& fcl() const;

    /// A walk of it against another mesh is about to begin: makes the hull, and later the balls, where so many have
    /// been that it pays. Returns whether it made something. Not beside other calls.
    /// @param near  the last walk of the two did not part them, and so would not have their hulls
    bool prepare_solids(bool near);
    /// Is there nothing more to prepare?
    bool has_solids() const { return (hull_ && (balls_ || !is_mesh())) || no_solids_ || !has_triangles(); }
    /// The convex solid around surface_mesh(); null: not there.
    const OuterHull* hull() const { return hull_.get(); }
    /// The balls within a mesh; null: not there.
    const InnerSpheres* balls() const { return balls_.get(); }

    std::uint32_t number = 0; ///< by which backends know its sphere-tree
    /// Frame in which a pair last needed the OBB tree.
    std::atomic<std::uint32_t> obb_tree_used = 0;
    std::unique_ptr<Ocst> spheres;  ///< the sphere-tree; null until a test reaches it
    std::unique_ptr<ObbTree> obb_tree; ///< the hierarchy of oriented boxes of surface_mesh(); null until a test reaches it
    std::string unreadable;         ///< why the hierarchy of a cooked mesh cannot be had; empty: it can

    /// Begins to load what pairs of it look at first.
    void prefetch() const { oncollide::prefetch(this, 192); }

private:
    /// Without a look at the geometry itself: of a large world it lies scattered in memory.
    template <class Kind>
    const Kind* as() const
    {
        return kind_ == index_of<Kind>(&geometry_->data) ? static_cast<const Kind*>(data_) : nullptr;
    }
    template <class Kind, class... Kinds>
    static constexpr std::size_t index_of(const std::variant<Kinds...>*)
    {
        std::size_t index = 0;
        ((!std::is_same_v<Kind, Kinds> && ++index) && ...);
        return index;
    }
    const Mesh& polytope() const;
    const Mesh& whole() const;

    std::shared_ptr<const Geometry> geometry_;
    const std::size_t kind_ = geometry_->data.index();
    const void* data_; ///< what there is of that kind: the geometry's, or this model's own
    const CookedFile* file_;
    std::unique_ptr<OuterHull> hull_;
    std::unique_ptr<InnerSpheres> balls_;
    PoseBounds bounds_;
    std::optional<OccupancyMap> own_map_;
    std::optional<Terrain> own_terrain_;
    mutable std::once_flag bounding_mesh_once_, closed_once_, parts_once_, fcl_once_, polytope_once_, convex_once_,
        shape_tree_once_, cells_once_, heights_once_, whole_once_;
    mutable std::optional<BoundingMesh> bounding_mesh_;
    mutable Mesh polytope_, whole_;
    mutable Convex convex_;
    mutable std::optional<ShapeTree> shape_tree_;
    mutable std::unique_ptr<MapTree> cells_;
    mutable std::unique_ptr<TerrainTree> heights_;
    mutable bool closed_ = false;
    mutable std::vector<PartPoints> parts_;
    mutable std::shared_ptr<const FclModel> fcl_;
    std::uint64_t walks_ = 0; ///< that what there is to prepare might have saved
    bool no_solids_ = false;  ///< the file cannot be read
};

/// Around a box that is moved, rounded outward.
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
    return !map()->each_cell(box_moved(box, into), [&](const MapCell& cell) {
        PartPoints points;
        points.fill(map()->box(cell).centre());
        return !visit(points);
    });
}

} // namespace oncollide
