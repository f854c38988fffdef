#include <oncollide/narrowphase/model.hpp>

#include <oncollide/narrowphase/inside/flat_faces.hpp>
#include <oncollide/narrowphase/inside/mesh_links.hpp>
#include <oncollide/scenes/cooked/cooked_map.hpp>
#include <oncollide/scenes/model/terrain/terrain_access.hpp>

namespace oncollide {

namespace {

const CookedFile* file_of(const GeometryData& data)
{
    if (const auto* mesh = std::get_if<std::shared_ptr<const CookedMesh>>(&data)) return &(*mesh)->file();
    if (const auto* terrain = std::get_if<Terrain>(&data))
        if (const CookedTerrainChunks* chunks = cooked_chunks(*terrain)) return &chunks->cooked()->file();
    if (const auto* map = std::get_if<OccupancyMap>(&data))
        if (const CookedMapChunks* chunks = cooked_chunks(*map)) return &chunks->cooked()->file();
    return nullptr;
}

} // namespace

Model::Model(std::shared_ptr<const Geometry> geometry, std::uint32_t number)
    : number_(number), geometry_(std::move(geometry)), kind_(kind_of(geometry_->data)),
      index_(static_cast<std::uint8_t>(geometry_->data.index())),
      data_(std::visit([](const auto& data) -> const void* { return &data; }, geometry_->data)),
      file_(file_of(geometry_->data)), bounds_(geometry_->data)
{
}

void Model::read_on_demand(ChunkBudget& budget)
{
    if (!file_ || cooked()) return;
    if (terrain())
        data_ = &own_terrain_.emplace(CookedTerrainChunks::terrain(cooked_chunks(*terrain())->cooked(), &budget));
    else
        data_ = &own_map_.emplace(CookedMapChunks::map(cooked_chunks(*map())->cooked(), &budget));
}

void Model::read_all() const
{
    if (!file_) return;
    if (cooked())
        mesh();
    else if (terrain())
        TerrainAccess::chunks(*terrain())->need_all();
    else
        MapAccess::cells(*map()).chunks()->need_all();
}

HeldChunks* Model::held_grid() const
{
    if (!file_ || cooked()) return nullptr;
    if (map()) return cooked_chunks(*map());
    const auto* const heights = heights_.made();
    return heights ? heights->get() : nullptr;
}

std::size_t Model::grid_bytes() const
{
    if (const auto* const heights = heights_.made()) return (*heights)->bytes();
    return file_ && map() ? MapAccess::cells(*map()).bytes() : 0;
}

const BoundingMesh& Model::bounding_mesh() const
{
    return bounding_mesh_.get([this] { return bounding_mesh_of(*shape()); });
}

const Mesh& Model::polytope() const
{
    return polytope_.get([this] { return surface_of_polytope(*shape()); });
}

const Mesh& Model::whole() const
{
    return whole_.get([this] { return cooked()->whole(); });
}

void Model::make_obb_tree(ChunkBudget* budget, BoxTotals& totals)
{
    const auto* cooked = std::get_if<std::shared_ptr<const CookedMesh>>(&geometry_->data);
    obb_tree_ = cooked && budget ? std::make_unique<ObbTree>(*cooked, *budget)
                                 : std::make_unique<ObbTree>(*surface_mesh(), &totals);
}

RayTree* Model::ray_tree() const
{
    constexpr std::size_t few = 32; // triangles
    ObbTree* const tree = obb_tree_.get();
    if (!tree || has_budget_ || tree->chunked() || tree->deformed() || tree->mesh().triangles.size() <= few)
        return nullptr;
    return ray_tree_.get([&] { return std::make_unique<RayTree>(*tree); }).get();
}

/// Reads all of a cooked mesh, and keeps none of it.
bool Model::prepare_solids(bool near)
{
    // Building takes as long as this many traversals per four vertices. The inner spheres save less, and must not delay
    // the first results.
    constexpr std::uint64_t walks_for_hull = 3, walks_for_inner_spheres = 32;
    if (has_solids() || (near && !hull_)) return false;
    if (4 * ++walks_ <= (hull_ ? walks_for_inner_spheres : walks_for_hull) * vertices()) return false;
    try {
        std::optional<Mesh> whole;
        if (cooked()) whole = cooked()->whole();
        const Mesh& mesh = whole ? *whole : *surface_mesh();
        if (hull_)
            inner_spheres_ = std::make_unique<InnerSpheres>(mesh);
        else
            hull_ = std::make_unique<OuterHull>(mesh);
    } catch (const ChunkFault&) { // the file keeps the fault
        no_solids_ = true;
    }
    return true;
}

/// Hulls and inner spheres would be made again and again.
void Model::deform(std::uint32_t first, std::uint32_t count, double radius2)
{
    ONCOLLIDE_ASSERT(as<Mesh>());
    bounds_.deform();
    hull_.reset(), inner_spheres_.reset(), no_solids_ = true;
    links_.reset(), closed_.reset(), parts_.reset(), fcl_.reset();
    ray_tree_.reset();
    if (obb_tree_) obb_tree_->deform(first, count, radius2);
}

void Model::change_heights(const TerrainRectangle& where)
{
    ONCOLLIDE_ASSERT(terrain() && !file_);
    bounds_.deform();
    parts_.reset(), fcl_.reset();
    if (auto* const heights = heights_.made()) (*heights)->change(where);
}

const Convex& Model::convex() const
{
    return convex_.get([this] {
        return std::holds_alternative<ConvexHull>(*shape()) ? convex_of_hull(polytope()) : convex_of(*shape());
    });
}

const HullFaces& Model::hull_faces() const
{
    return hull_faces_.get([this] { return HullFaces(polytope()); });
}

const MeshLinks& Model::links() const
{
    return *links_.get([this] {
        const Mesh& mesh = has_triangles() ? *surface_mesh() : bounding_mesh().mesh;
        MeshLinks links = links_of(mesh);
        if (is_mesh())
            if (std::optional<FlatFaces> joined = join_flat_faces(mesh, links)) {
                auto flat = std::make_shared<FlatSurface>(std::move(*joined));
                if (flat->links.closed == links.closed) links.flat = std::move(flat);
            }
        return std::make_shared<const MeshLinks>(std::move(links));
    });
}

std::size_t Model::links_bytes() const
{
    const auto of = [](const auto&... lists) { return (... + (lists.capacity() * sizeof(lists[0]))); };
    const auto of_links = [&](const MeshLinks& l) {
        return of(l.vertex, l.neighbours, l.ridges) + l.tips.capacity() / 8; // tips stores one bit per vertex
    };
    const auto* const made = links_.made();
    if (!made) return 0;
    const MeshLinks* const links = made->get();
    std::size_t sum = of_links(*links);
    if (const FlatSurface* flat = links->flat.get())
        sum += of_links(flat->links) +
               of(flat->faces.mesh.vertices, flat->faces.mesh.triangles, flat->faces.vertex, flat->faces.face) +
               flat->totals.bytes;
    return sum;
}

ObbTree& Model::bounding_tree() const
{
    return *bounding_tree_.get([this] { return std::make_unique<ObbTree>(bounding_mesh().mesh); });
}

const ShapeTree& Model::shape_tree() const
{
    return shape_tree_.get([this] { return ShapeTree(convex(), bounds_of(*shape())); });
}

MapTree& Model::cells() const
{
    return *cells_.get([this] { return std::make_unique<MapTree>(*map()); });
}

TerrainTree& Model::heights() const
{
    return *heights_.get([this] { return std::make_unique<TerrainTree>(*terrain()); });
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
    return closed_.get([this] {
        if (!is_mesh()) return false;
        const std::optional<bool> known = cooked() ? cooked()->closed() : std::nullopt;
        return known ? *known : is_closed(*mesh());
    });
}

std::span<const PartPoints> Model::parts() const
{
    return parts_.get([this] {
        if (terrain()) return part_points_of(*terrain());
        if (!cooked()) return part_points_of(geometry_->data);
        if (std::optional known = cooked()->parts()) return std::move(*known);
        return part_points_of(whole());
    });
}

const FclModel& Model::fcl() const
{
    return *fcl_.get([this] { return cooked() ? make_fcl_model(*mesh()) : make_fcl_model(geometry_->data); });
}

std::string Model::validate(std::size_t most) const
{
    std::string fault;
    const auto look_at = [&](const auto& tree, std::size_t size, const char* name) {
        if (!fault.empty() || !tree || size > most) return;
        if (fault = tree->validate(); !fault.empty()) fault = geometry_->name + ": " + name + ": " + fault;
    };
    look_at(spheres_, spheres_ ? spheres_->size() : 0, "sphere-tree");
    look_at(obb_tree_, obb_tree_ ? obb_tree_->nodes() : 0, "OBB tree");
    if (const auto* const rays = ray_tree_.made()) look_at(*rays, triangles(), "tree for segments");
    if (const auto* const heights = heights_.made()) look_at(*heights, terrain()->cells(), "terrain tree");
    return fault;
}

} // namespace oncollide
