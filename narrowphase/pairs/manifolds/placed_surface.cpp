#include <oncollide/narrowphase/pairs/manifolds/placed_surface.hpp>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/feature_bits.hpp>
#include <oncollide/scenes/model/terrain/terrain_access.hpp>

namespace oncollide {

namespace {

constexpr std::uint32_t cell_faces = 12;

std::uint64_t hash_of(const MapCell& cell, std::uint32_t part)
{
    const std::uint64_t place = std::uint64_t(std::uint32_t(cell.x)) << 32 | std::uint32_t(cell.y);
    const std::uint64_t rest = std::uint64_t(std::uint32_t(cell.z)) << 32 | std::uint32_t(cell.side);
    return splitmix(splitmix(place) ^ splitmix(rest ^ std::uint64_t{part} << 58));
}

} // namespace

PlacedSurface::PlacedSurface(Model& model, const RelativePose& into, const Aabb& other, bool joins)
    : model_(model), into_(into)
{
    switch (model.kind()) {
    case Kind::mesh:
    case Kind::polytope:
        mesh_ = model.surface_mesh(), links_ = &model.links(), tree_ = model.obb_tree(), solid_ = links_->closed;
        if (FlatSurface* flat = joins ? links_->flat.get() : nullptr)
            flat_ = &flat->faces, mesh_ = &flat->faces.mesh, links_ = &flat->links, tree_ = &flat->tree;
        break;
    case Kind::terrain:
        terrain_ = &model.heights(), error_ = model.terrain()->error();
        break;
    case Kind::round:
        mesh_ = &model.bounding_mesh().mesh, links_ = &model.links(), tree_ = &model.bounding_tree();
        error_ = model.covering_error();
        break;
    case Kind::map:
        add_cells(other);
        break;
    case Kind::half_space:
        add_plane(other);
    }
}

/// Cells of one size that share a face are one solid. Others have surfaces of their own.
void PlacedSurface::add_cells(const Aabb& other)
{
    const OccupancyMap& map = *model_.map();
    std::set<MapCell> cells;
    MapAccess::each_cell(map, other, [&](const MapCell& cell) { return cells.insert(cell), true; });
    std::map<MapCell, std::uint32_t> vertices; // a corner, with the side of its cells
    struct Side {
        std::uint32_t low, high, cell, triangle;
        int corner;
    };
    std::vector<Side> sides;
    std::uint32_t number = 0;
    for (const MapCell& cell : cells) {
        const Aabb box = MapAccess::box(map, cell);
        for (std::uint32_t face = 0; face < cell_faces; ++face) {
            const auto axis = 2 - int(face / 4); // as box_faces: z, y, x, the low face first
            MapCell beyond = cell;
            (axis == 0 ? beyond.x : axis == 1 ? beyond.y : beyond.z) += face % 4 < 2 ? -cell.side : cell.side;
            if (cells.contains(beyond)) continue;
            Triangle t;
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t c = box_faces[face][k];
                const auto along = [&](unsigned bit) { return c & bit ? cell.side : 0; };
                const MapCell corner{cell.x + along(1), cell.y + along(2), cell.z + along(4), cell.side};
                const auto [at, added] = vertices.emplace(corner, own_mesh_.vertices.size());
                if (added) own_mesh_.vertices.push_back(corner_of(box, c)), corners_.push_back(corner);
                t[k] = at->second;
            }
            for (int k = 0; k < 3; ++k)
                sides.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3]), number,
                                 std::uint32_t(own_mesh_.triangles.size()), k});
            own_mesh_.triangles.push_back(t), faces_.emplace_back(cell, face);
        }
        ++number;
    }
    if (own_mesh_.triangles.empty()) return;
    for (const Eigen::Vector3d& v : own_mesh_.vertices) own_mesh_.bounds.add(v);
    for (std::uint32_t v = 0; v < own_mesh_.vertices.size(); ++v) own_links_.vertex.push_back(v);
    own_links_.neighbours.assign(own_mesh_.triangles.size(), {none, none, none});
    std::ranges::sort(sides, {}, [](const Side& s) { return std::tuple(s.low, s.high, s.cell, s.triangle); });
    // An edge has two sides, or four if two cells share only the edge; each cell then connects its own two.
    for (std::size_t i = 0; i + 1 < sides.size(); i += 2) {
        own_links_.neighbours[sides[i].triangle][sides[i].corner] = sides[i + 1].triangle;
        own_links_.neighbours[sides[i + 1].triangle][sides[i + 1].corner] = sides[i].triangle;
    }
    mesh_ = &own_mesh_, links_ = &own_links_, tree_ = &own_tree_.emplace(own_mesh_);
}

void PlacedSurface::add_plane(const Aabb& other)
{
    const Eigen::Vector3d middle = other.centre();
    const double reach = 4 * other.diagonal();
    for (const auto& [x, y] : {std::pair(-1, -1), std::pair(2, -1), std::pair(-1, 2)})
        own_mesh_.vertices.emplace_back(middle.x() + x * reach, middle.y() + y * reach, 0);
    own_mesh_.triangles.push_back({0, 1, 2});
    for (const Eigen::Vector3d& v : own_mesh_.vertices) own_mesh_.bounds.add(v);
    own_links_ = links_of(own_mesh_);
    mesh_ = &own_mesh_, links_ = &own_links_, tree_ = &own_tree_.emplace(own_mesh_);
}

std::array<std::uint32_t, 3> PlacedSurface::corners(std::uint32_t triangle) const
{
    if (terrain_) {
        const Terrain& terrain = *model_.terrain();
        std::array<std::uint32_t, 3> vertices;
        const auto places = terrain.corners(triangle);
        for (int k = 0; k < 3; ++k) vertices[k] = places[k].row * (terrain.cells_x() + 1) + places[k].column;
        return vertices;
    }
    const Triangle& t = mesh_->triangles[triangle];
    const auto& v = links_->vertex;
    if (links_->reversed) return {v[t[1]], v[t[0]], v[t[2]]};
    return {v[t[0]], v[t[1]], v[t[2]]};
}

Eigen::Vector3d PlacedSurface::point(std::uint32_t vertex) const
{
    if (!terrain_) return into_(mesh_->vertices[vertex]);
    const std::uint32_t columns = model_.terrain()->cells_x() + 1;
    return into_(TerrainAccess::point(*model_.terrain(), vertex % columns, vertex / columns));
}

std::uint32_t PlacedSurface::across(std::uint32_t triangle, int k) const
{
    if (!terrain_) {
        return links_->neighbours[triangle][links_->reversed ? reversed_edges[k] : k];
    }
    const Terrain& terrain = *model_.terrain();
    const auto own = corners(triangle);
    const std::uint32_t from = own[(k + 1) % 3], to = own[k], cells_x = terrain.cells_x();
    const std::uint32_t cell_x = triangle / 2 % cells_x, cell_y = triangle / 2 / cells_x;
    for (const auto& [dx, dy] :
         {std::pair(0, 0), std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)}) {
        const std::uint32_t x = cell_x + dx, y = cell_y + dy;
        if (x >= cells_x || y >= terrain.cells_y() || !terrain.has_cell(x, y)) continue;
        for (const std::uint32_t half : {0u, 1u}) {
            const std::uint32_t t = 2 * (y * cells_x + x) + half;
            const auto c = corners(t);
            for (int i = 0; i < 3; ++i)
                if (c[i] == from && c[(i + 1) % 3] == to) return t;
        }
    }
    return none;
}

double PlacedSurface::behind(const Eigen::Vector3d& point, const Eigen::Vector3d& out) const
{
    const Kind kind = model_.kind();
    if (kind == Kind::mesh || kind == Kind::terrain) return 0;
    return std::max(out.dot(farthest(out) - point), 0.0);
}

std::optional<bool> PlacedSurface::holds(const Eigen::Vector3d& point, PointLocator& locator) const
{
    const Eigen::Vector3d p = into_.rotation.transpose() * (point - into_.translation);
    const auto in = [&](const Aabb& box) {
        return (p.array() >= box.min.array()).all() && (p.array() <= box.max.array()).all();
    };
    switch (model_.kind()) {
    case Kind::half_space:
        return p.z() < 0;
    case Kind::map: {
        bool touches = false;
        for (const auto& [cell, face] : faces_) {
            const Aabb box = MapAccess::box(*model_.map(), cell);
            if (((p - box.min).array() > 0).all() && ((box.max - p).array() > 0).all()) return true;
            touches |= in(box);
        }
        return touches ? std::nullopt : std::optional(false);
    }
    case Kind::terrain: {
        const Terrain& terrain = *model_.terrain();
        const double x = (p.x() - terrain.origin().x()) / terrain.spacing().x(),
                     y = (p.y() - terrain.origin().y()) / terrain.spacing().y();
        if (!(x >= 0 && y >= 0 && x < terrain.cells_x() && y < terrain.cells_y())) return false;
        const auto column = static_cast<std::uint32_t>(x), row = static_cast<std::uint32_t>(y);
        if (!terrain.has_cell(column, row)) return false;
        for (const std::uint32_t half : {0u, 1u}) {
            const auto [a, b, c] = terrain_->points(2 * (row * terrain.cells_x() + column) + half);
            const Eigen::Vector2d u = (b - a).head<2>(), v = (c - a).head<2>(), w = (p - a).head<2>();
            const double area = u.x() * v.y() - u.y() * v.x();
            const double s = (w.x() * v.y() - w.y() * v.x()) / area, t = (u.x() * w.y() - u.y() * w.x()) / area;
            if (s >= -0x1p-40 && t >= -0x1p-40 && s + t <= 1 + 0x1p-40)
                return p.z() < a.z() + s * (b.z() - a.z()) + t * (c.z() - a.z());
        }
        return false;
    }
    default:
        if (!solid_) return false;
        const double slack = 0x1p-40 * (mesh_->bounds.diagonal() + p.norm());
        if (!in({mesh_->bounds.min.array() - slack, mesh_->bounds.max.array() + slack})) return false;
        const PointLocation place = locator.place(point, *mesh_, tree_, into_);
        if (place == PointLocation::surface) return {};
        return place == PointLocation::inside;
    }
}

double PlacedSurface::reach() const
{
    if (mesh_ == &own_mesh_) return into_(own_mesh_.bounds.centre()).norm() + own_mesh_.bounds.diagonal();
    return into_.translation.norm() + model_.reach();
}

Eigen::Vector3d PlacedSurface::farthest(const Eigen::Vector3d& direction) const
{
    const Eigen::Vector3d d = rotated_back(direction);
    if (round()) return into_(model_.convex().support(d) + model_.convex().radius * d.normalized());
    if (terrain_ || empty()) {
        const Aabb box = bounds_of(model_.geometry().data);
        return into_((d.array() > 0).select(box.max, box.min));
    }
    return into_(*std::ranges::max_element(mesh_->vertices, {}, [&](const Eigen::Vector3d& v) { return d.dot(v); }));
}

bool PlacedSurface::any_part_point(FunctionRef<bool(const Eigen::Vector3d&)> visit) const
{
    if (model_.kind() == Kind::map)
        return std::ranges::any_of(
            faces_, [&](const auto& face) { return visit(into_(MapAccess::box(*model_.map(), face.first).centre())); });
    if (model_.kind() == Kind::half_space) return false;
    return std::ranges::any_of(model_.parts(), [&](const PartPoints& part) {
        return std::ranges::any_of(part, [&](const Eigen::Vector3d& p) { return visit(into_(p)); });
    });
}

FeatureBits PlacedSurface::vertex(std::uint32_t v) const
{
    if (round()) return face_feature(0);
    return vertex_feature(corners_.empty() ? (flat_ ? flat_->vertex[v] : v) : hash_of(corners_[v], 0) >> 2);
}

FeatureBits PlacedSurface::edge(std::uint32_t from, std::uint32_t to) const
{
    if (round()) return face_feature(0);
    if (flat_) from = flat_->vertex[from], to = flat_->vertex[to];
    if (corners_.empty()) return edge_feature(from, to);
    if (from > to) std::swap(from, to);
    return edge_feature(splitmix(vertex(from) ^ splitmix(vertex(to))));
}

FeatureBits PlacedSurface::face(std::uint32_t triangle) const
{
    if (round()) return face_feature(0);
    if (faces_.empty()) return face_feature(flat_ ? flat_->face[triangle] : triangle);
    const auto& [cell, face] = faces_[triangle];
    return face_feature(hash_of(cell, face + 1) >> 2);
}

double rounding_of(const PlacedSurface& a, const PlacedSurface& b)
{
    return 0x1p-48 * (a.reach() + b.reach()); // 16 roundings of the largest coordinate; a placed vertex needs 4
}

} // namespace oncollide
