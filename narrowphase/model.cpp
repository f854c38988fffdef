#include <oncollide/narrowphase/model.hpp>

namespace oncollide {

Model::Model(std::shared_ptr<const Geometry> geometry) : geometry_(std::move(geometry)), bounds_(geometry_->data) {}

const BoundingMesh& Model::bounding_mesh() const
{
    std::call_once(bounding_mesh_once_, [this] { bounding_mesh_ = bounding_mesh_of(*shape()); });
    return *bounding_mesh_;
}

const Mesh& Model::polytope() const
{
    std::call_once(polytope_once_, [this] { polytope_ = surface_of_polytope(*shape()); });
    return polytope_;
}

const Convex& Model::convex() const
{
    std::call_once(convex_once_, [this] {
        const bool hull = std::holds_alternative<ConvexHull>(*shape());
        convex_ = hull ? convex_of_hull(polytope()) : convex_of(*shape());
    });
    return convex_;
}

const ShapeTree& Model::shape_tree() const
{
    std::call_once(shape_tree_once_, [this] { shape_tree_.emplace(convex(), bounds_of(*shape())); });
    return *shape_tree_;
}

MapTree& Model::cells() const
{
    std::call_once(cells_once_, [this] { cells_ = std::make_unique<MapTree>(*map()); });
    return *cells_;
}

TerrainTree& Model::heights() const
{
    std::call_once(heights_once_, [this] { heights_ = std::make_unique<TerrainTree>(*terrain()); });
    return *heights_;
}

RootCell Model::root_cell() const
{
    return root_cell_around(shape() ? bounding_mesh().mesh.bounds : bounds_of(geometry_->data));
}

Surface Model::surface(const RootCell& root) const
{
    if (const Mesh* triangles = mesh()) return mesh_surface(*triangles, root);
    if (const OccupancyMap* cells = map()) return map_surface(*cells, root);
    return solid_surface(bounding_mesh().mesh, root);
}

bool Model::closed() const
{
    std::call_once(closed_once_, [this] { closed_ = mesh() && is_closed(*mesh()); });
    return closed_;
}

std::span<const PartPoints> Model::parts() const
{
    std::call_once(parts_once_, [this] { parts_ = part_points_of(geometry_->data); });
    return parts_;
}

const FclModel& Model::fcl() const
{
    std::call_once(fcl_once_, [&] { fcl_ = make_fcl_model(geometry_->data); });
    return *fcl_;
}

bool Model::expect_hull()
{
    // Making it costs about as much as so many walks.
    return !hull_ && has_triangles() && ++walks_ > surface_mesh()->vertices.size();
}

} // namespace oncollide
