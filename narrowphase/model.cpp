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
    return map() ? static_cast<HeldChunks*>(cooked_chunks(*map())) : heights_.get();
}

std::size_t Model::grid_bytes() const
{
    if (heights_) return heights_->bytes();
    return file_ && map() ? MapAccess::cells(*map()).bytes() : 0;
}

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

const Mesh& Model::whole() const
{
    std::call_once(whole_once_, [this] { whole_ = cooked()->whole(); });
    return whole_;
}

void Model::make_obb_tree(ChunkBudget* budget, BoxTotals& totals)
{
    const auto* cooked = std::get_if<std::shared_ptr<const CookedMesh>>(&geometry_->data);
    obb_tree_ = cooked && budget ? std::make_unique<ObbTree>(*cooked, *budget)
                                 : std::make_unique<ObbTree>(*surface_mesh(), &totals);
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

const Convex& Model::convex() const
{
    std::call_once(convex_once_, [this] {
        const bool hull = std::holds_alternative<ConvexHull>(*shape());
        convex_ = hull ? convex_of_hull(polytope()) : convex_of(*shape());
    });
    return convex_;
}

const MeshLinks& Model::links() const
{
    std::call_once(links_once_, [this] {
        const Mesh& mesh = has_triangles() ? *surface_mesh() : bounding_mesh().mesh;
        MeshLinks links = links_of(mesh);
        if (is_mesh())
            if (std::optional<FlatFaces> joined = join_flat_faces(mesh, links)) {
                auto flat = std::make_shared<FlatSurface>(std::move(*joined));
                if (flat->links.closed == links.closed) links.flat = std::move(flat);
            }
        links_ = std::make_shared<const MeshLinks>(std::move(links));
        links_made_ = links_.get();
    });
    return *links_;
}

std::size_t Model::links_bytes() const
{
    const auto of = [](const auto&... lists) { return (... + (lists.capacity() * sizeof(lists[0]))); };
    const auto of_links = [&](const MeshLinks& l) {
        return of(l.vertex, l.neighbours, l.ridges) + l.tips.capacity() / 8; // tips stores one bit per vertex
    };
    const MeshLinks* links = links_made_;
    if (!links) return 0;
    std::size_t sum = of_links(*links);
    if (const FlatSurface* flat = links->flat.get())
        sum += of_links(flat->links) +
               of(flat->faces.mesh.vertices, flat->faces.mesh.triangles, flat->faces.vertex, flat->faces.face) +
               flat->totals.bytes;
    return sum;
}

ObbTree& Model::bounding_tree() const
{
    std::call_once(bounding_tree_once_, [this] { bounding_tree_ = std::make_shared<ObbTree>(bounding_mesh().mesh); });
    return *bounding_tree_;
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
    std::call_once(closed_once_, [this] {
        if (!is_mesh()) return;
        const std::optional<bool> known = cooked() ? cooked()->closed() : std::nullopt;
        closed_ = known ? *known : is_closed(*mesh());
    });
    return closed_;
}

std::span<const PartPoints> Model::parts() const
{
    std::call_once(parts_once_, [this] {
        if (terrain())
            parts_ = part_points_of(*terrain());
        else if (!cooked())
            parts_ = part_points_of(geometry_->data);
        else if (std::optional known = cooked()->parts())
            parts_ = std::move(*known);
        else
            parts_ = part_points_of(whole());
    });
    return parts_;
}

const FclModel& Model::fcl() const
{
    std::call_once(fcl_once_, [&] { fcl_ = cooked() ? make_fcl_model(*mesh()) : make_fcl_model(geometry_->data); });
    return *fcl_;
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
    look_at(heights_, terrain() ? terrain()->cells() : 0, "terrain tree");
    return fault;
}

} // namespace oncollide
