#include <oncollide/scenes/files/geometry_recipe.hpp>

#include <fmt/format.h>

#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/scenes/cooked/cooked_map.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/cooked/cooked_terrain.hpp>
#include <oncollide/scenes/files/deformation_entry.hpp>
#include <oncollide/scenes/files/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>
#include <oncollide/scenes/model/terrain/terrain_access.hpp>

namespace oncollide {

namespace {

namespace fs = std::filesystem;

const Generators& generators_for(const Node& node, const SceneReading& reading)
{
    if (!reading.generators) node.fail("needs generators, which this program does not pass to load_scene()");
    return *reading.generators;
}

std::vector<Eigen::Vector3d> points_of(const Node& node)
{
    std::vector<Eigen::Vector3d> points;
    points.reserve(node.size());
    for (const Node& point : node) points.push_back(point.vector3());
    return points;
}

Mesh listed_mesh(const Node& node, const std::string& name)
{
    const Node vertices = node["vertices"], triangles = node["triangles"];
    std::vector<Triangle> indices;
    indices.reserve(triangles.size());
    for (const Node& triangle : triangles) {
        if (triangle.size() != 3) triangle.fail(fmt::format("has {} vertices, must have three", triangle.size()));
        auto corner = indices.emplace_back().begin();
        for (const Node& number : triangle) *corner++ = static_cast<std::uint32_t>(number.integer(0, 0xffffffff));
    }
    return make_mesh(name, points_of(vertices), std::move(indices));
}

/// The same transforms as load_mesh: scale, then fit, then centre.
Mesh fitted(const std::string& name, Mesh mesh, const MeshOptions& options)
{
    double scale = options.scale;
    if (options.fit_diagonal > 0) {
        const double diagonal = mesh.bounds.diagonal();
        if (!(diagonal > 0)) throw Error(ErrorKind::bad_data, name + ": a mesh without extent cannot be fitted");
        scale = options.fit_diagonal / diagonal;
    }
    if (scale == 1 && !options.centre) return mesh;
    const Eigen::Vector3d origin = options.centre ? mesh.bounds.centre() : Eigen::Vector3d::Zero();
    return transformed(name, std::move(mesh), scale, origin);
}

/// A cooked mesh stays in its file.
GeometryData read_mesh(const Node& node, const std::string& name, const fs::path& folder, const SceneReading& reading)
{
    node.only({"file", "generate", "vertices", "triangles", "scale", "fit_diagonal", "centre"});
    const bool listed = node.has("vertices") || node.has("triangles");
    if (node.has("file") + node.has("generate") + listed != 1)
        node.fail("must have exactly one of: file, generate, vertices with triangles");
    const MeshOptions options{.scale = node.positive("scale", 1),
                              .fit_diagonal = node.positive("fit_diagonal", 0),
                              .centre = node.has("centre") && node["centre"].boolean()};
    if (node.has("file")) {
        const Node file = node["file"];
        return at(file, [&]() -> GeometryData {
            const fs::path path = file_in(folder, file.text());
            if (!reading.on_demand) return load_mesh(path, options);
            if (is_cooked(path) && options == MeshOptions{}) return std::make_shared<const CookedMesh>(path);
            if (reading.cooked)
                if (const auto cooked = reading.cooked(path, options))
                    return std::make_shared<const CookedMesh>(*cooked);
            return load_mesh(path, options);
        });
    }
    if (node.has("generate")) {
        const Node generator = node["generate"];
        return fitted(name, at(generator, [&] { return generators_for(generator, reading).mesh(generator); }), options);
    }
    return at(node, [&] { return fitted(name, listed_mesh(node, name), options); });
}

Shape read_shape(const Node& node)
{
    const std::string_view kind = node["kind"].text();
    if (kind == "sphere") return node.only({"kind", "radius"}), Sphere{node["radius"].number()};
    if (kind == "box") return node.only({"kind", "half"}), Box{node["half"].vector3()};
    if (kind == "capsule") {
        node.only({"kind", "radius", "length"});
        return Capsule{node["radius"].number(), node["length"].number()};
    }
    if (kind == "cylinder") {
        node.only({"kind", "radius", "length"});
        return Cylinder{node["radius"].number(), node["length"].number()};
    }
    if (kind == "convex_hull") {
        node.only({"kind", "points"});
        return ConvexHull{points_of(node["points"])};
    }
    if (kind == "ellipsoid") {
        node.only({"kind", "semi_axes"});
        return Ellipsoid{node["semi_axes"].vector3()};
    }
    if (kind == "cone") {
        node.only({"kind", "radius", "length"});
        return Cone{node["radius"].number(), node["length"].number()};
    }
    if (kind == "half_space") return node.only({"kind"}), HalfSpace{};
    node["kind"].fail(fmt::format(
        "no shape named '{}'{}", kind,
        valid_names(kind, {"sphere", "box", "capsule", "cylinder", "convex_hull", "ellipsoid", "cone", "half_space"})));
}

OccupancyMap read_map(const Node& node, const fs::path& folder, const SceneReading& reading)
{
    if (node.has("file")) {
        MapOptions options;
        node.only({"file", "unknown", "occupancy_threshold"});
        if (node.has("unknown")) {
            const Node unknown = node["unknown"];
            if (unknown.text() != "free" && unknown.text() != "occupied") unknown.fail("valid: free, occupied");
            options.unknown_is_occupied = unknown.text() == "occupied";
        }
        if (node.has("occupancy_threshold")) options.occupancy_threshold = node["occupancy_threshold"].number();
        const Node file = node["file"];
        return at(file, [&] { return load_octomap(file_in(folder, file.text()), options); });
    }
    const Node building = node[node.one_of({"file", "building"})];
    return at(building, [&] { return generators_for(building, reading).building(building); });
}

Terrain read_terrain(const Node& node, const fs::path& folder, const SceneReading& reading)
{
    if (node.has("hills")) {
        node.only({"hills"});
        const Node hills = node["hills"];
        return at(hills, [&] { return generators_for(hills, reading).hills(hills); });
    }
    node.only({"file", "spacing", "origin", "vertical_scale", "no_data", "bytes", "error", "centre", "diagonal",
               "diagonals", "columns", "rows", "type"});
    TerrainOptions options;
    const auto pair = [&](const Node& value) {
        Eigen::Vector2d both;
        if (value.is_array())
            value.numbers(2, both.data());
        else
            both.setConstant(value.number());
        return both;
    };
    if (node.has("spacing")) options.spacing = pair(node["spacing"]);
    if (node.has("origin")) options.origin = node["origin"].vector3();
    options.vertical_scale = node.positive("vertical_scale", 1);
    if (node.has("no_data")) {
        const Node no_data = node["no_data"];
        if (no_data.is_text() && no_data.text() != "nan") no_data.fail("must be a number or \"nan\"");
        options.no_data = no_data.is_text() ? std::numeric_limits<double>::quiet_NaN() : no_data.number();
    }
    if (node.has("bytes")) options.bytes = static_cast<int>(node["bytes"].integer(0, 8));
    options.error = node.number("error", 0);
    options.centre = node.has("centre") && node["centre"].boolean();
    if (node.has("diagonal")) {
        const std::string_view diagonal = node["diagonal"].text();
        if (diagonal != "rising" && diagonal != "falling") node["diagonal"].fail("must be \"rising\" or \"falling\"");
        options.diagonal = diagonal == "rising" ? CellDiagonal::rising : CellDiagonal::falling;
    }
    if (node.has("diagonals")) options.diagonals = file_of(node["diagonals"], folder);
    if (node.has("columns")) options.columns = static_cast<std::uint32_t>(node["columns"].integer(2, 0xffffffff));
    if (node.has("rows")) options.rows = static_cast<std::uint32_t>(node["rows"].integer(2, 0xffffffff));
    if (node.has("type")) options.type = node["type"].text();
    const Node file = node["file"];
    return at(file, [&] { return load_terrain(file_in(folder, file.text()), options); });
}

/// The entry of a terrain made in code; the caller writes its heights to `file`, and its diagonals beside it.
Json terrain_entry(const Terrain& terrain, const std::string& file)
{
    const Eigen::Vector2d& spacing = terrain.spacing();
    const Eigen::Vector3d& origin = terrain.origin();
    Json entry = {{"file", file},
                  {"spacing", {spacing.x(), spacing.y()}},
                  {"origin", {origin.x(), origin.y(), origin.z()}},
                  {"no_data", "nan"}};
    if (terrain.error() > 0) entry["error"] = terrain.error();
    if (terrain.mixed_diagonals())
        entry["diagonals"] = diagonals_file(file);
    else if (terrain.diagonal(0, 0) == CellDiagonal::falling)
        entry["diagonal"] = "falling";
    return entry;
}

Json list_of(const std::vector<Eigen::Vector3d>& points)
{
    Json list = Json::array();
    for (const Eigen::Vector3d& p : points) list.push_back({p.x(), p.y(), p.z()});
    return list;
}

Json entry_of(const Sphere& s)
{
    return {{"kind", "sphere"}, {"radius", s.radius}};
}
Json entry_of(const Box& b)
{
    return {{"kind", "box"}, {"half", {b.half.x(), b.half.y(), b.half.z()}}};
}
Json entry_of(const Capsule& c)
{
    return {{"kind", "capsule"}, {"radius", c.radius}, {"length", c.length}};
}
Json entry_of(const Cylinder& c)
{
    return {{"kind", "cylinder"}, {"radius", c.radius}, {"length", c.length}};
}
Json entry_of(const ConvexHull& h)
{
    return {{"kind", "convex_hull"}, {"points", list_of(h.points)}};
}
Json entry_of(const Ellipsoid& e)
{
    return {{"kind", "ellipsoid"}, {"semi_axes", {e.semi_axes.x(), e.semi_axes.y(), e.semi_axes.z()}}};
}
Json entry_of(const Cone& c)
{
    return {{"kind", "cone"}, {"radius", c.radius}, {"length", c.length}};
}
Json entry_of(const HalfSpace&)
{
    return {{"kind", "half_space"}};
}

/// Changes the paths of the entry's files, if it has any.
template <class Change>
void change_file(Json& entry, Change change)
{
    for (const char* kind : {"mesh", "octomap", "terrain"})
        for (const char* key : {"file", "diagonals"})
            if (entry.contains(kind) && entry[kind].contains(key)) {
                Json& file = entry[kind][key];
                file = portable_name(change(path_of(file.get<std::string>())));
            }
}

/// The entry has been read before, so it has the right types.
std::string recipe_of(const Node& entry, const fs::path& folder)
{
    Json recipe = Json::parse(entry.source());
    recipe.erase("deformation"); // which has its own
    change_file(recipe, [&](const fs::path& file) { return absolute_path(folder / file); });
    try {
        return recipe.dump();
    } catch (const Json::exception&) {
        throw Error(ErrorKind::bad_data, "the path of its file is not UTF-8 text");
    }
}

GeometryId add_rigid(SceneInfo& scene, const std::string& name, const Node& entry, std::string_view source,
                     const fs::path& folder, const SceneReading& reading)
{
    const Node node = entry[source];
    if (source == "shape") return at(node, [&] { return scene.add(name, read_shape(node)); });

    if (source == "octomap") {
        OccupancyMap map = read_map(node, folder, reading);
        if (MapAccess::cells(map).chunks() && !reading.on_demand) MapAccess::cells(map).chunks()->need_all();
        return at(entry, [&] { return scene.add(name, std::move(map), recipe_of(entry, folder)); });
    }
    if (source == "terrain") {
        Terrain terrain = read_terrain(node, folder, reading);
        if (TerrainAccess::chunks(terrain) && !reading.on_demand) TerrainAccess::chunks(terrain)->need_all();
        return at(entry, [&] { return scene.add(name, std::move(terrain), recipe_of(entry, folder)); });
    }
    GeometryData mesh = read_mesh(node, name, folder, reading);
    const auto* cooked = std::get_if<std::shared_ptr<const CookedMesh>>(&mesh);
    if (const std::size_t flat = cooked ? (*cooked)->zero_area() : std::get<Mesh>(mesh).zero_area)
        scene.warnings.push_back(
            fmt::format("{}: {} triangle{} without area (kept)", name, flat, flat == 1 ? "" : "s"));
    return at(entry, [&] { return scene.add(name, std::move(mesh), recipe_of(entry, folder)); });
}

} // namespace

GeometryId add_geometry(SceneInfo& scene, std::string_view given_name, const Node& entry, const fs::path& folder,
                        const SceneReading& reading)
{
    const std::string name(given_name);
    if (!entry.is_object() || !entry.has("deformation"))
        return add_rigid(scene, name, entry, entry.one_of({"mesh", "shape", "octomap", "terrain"}), folder, reading);
    const Node deformation = entry["deformation"];
    for (const char* kind : {"shape", "octomap", "terrain"})
        if (entry.has(kind)) deformation.fail(fmt::format("is for meshes; this geometry is of the kind '{}'", kind));
    entry.only({"mesh", "deformation"});
    SceneReading in_memory = reading;
    in_memory.on_demand = false;
    const GeometryId mesh = add_rigid(scene, name, entry, "mesh", folder, in_memory);
    at(deformation, [&] { scene.deform(mesh, read_deformation(deformation, folder)); });
    return mesh;
}

void Expansion::count(const Geometry& geometry, const Node& entry)
{
    using Cooked = std::shared_ptr<const CookedMesh>; // takes no memory that its file does not have
    if (std::holds_alternative<Shape>(geometry.data) || std::holds_alternative<Cooked>(geometry.data)) return;
    const Mesh* mesh = std::get_if<Mesh>(&geometry.data);
    const Terrain* terrain = std::get_if<Terrain>(&geometry.data);
    const Node node = entry[mesh ? "mesh" : terrain ? "terrain" : "octomap"];
    if (node.has("vertices")) return;
    const auto* map = std::get_if<OccupancyMap>(&geometry.data);
    if ((terrain && TerrainAccess::chunks(*terrain)) || (map && MapAccess::cells(*map).chunks())) return;
    if (node.has("file") && files_.emplace(node["file"].text()).second) return;
    if (mesh)
        triangles_ += mesh->triangles.size();
    else if (terrain)
        triangles_ += 2 * terrain->cells();
    else
        cells_ += map->count();
    if (triangles_ > most_triangles || cells_ > most_cells)
        entry.fail(fmt::format("too much for one scene: generated geometries and files used again may together have at "
                               "most {} triangles and {} cells; bodies can share a geometry",
                               most_triangles, most_cells));
}

Json entry_of(const Geometry& geometry, const fs::path& folder, const std::string& made_file)
{
    if (const Shape* shape = std::get_if<Shape>(&geometry.data))
        return {{"shape", std::visit([](const auto& s) { return entry_of(s); }, *shape)}};
    if (!geometry.recipe.empty()) {
        Json entry = Json::parse(geometry.recipe);
        change_file(entry, [&](const fs::path& file) { return path_from(folder, file); });
        return entry;
    }
    if (const auto* cooked = std::get_if<std::shared_ptr<const CookedMesh>>(&geometry.data))
        return {{"mesh", {{"file", portable_name(path_from(folder, path_of((*cooked)->name())))}}}};
    if (const Mesh* mesh = std::get_if<Mesh>(&geometry.data))
        return {{"mesh", {{"vertices", list_of(mesh->vertices)}, {"triangles", mesh->triangles}}}};
    if (const Terrain* terrain = std::get_if<Terrain>(&geometry.data))
        return {{"terrain", terrain_entry(*terrain, made_file)}};
    Json map{{"file", made_file}};
    if (MapAccess::cells(std::get<OccupancyMap>(geometry.data)).unknown_is_solid()) map["unknown"] = "occupied";
    return {{"octomap", std::move(map)}};
}

} // namespace oncollide
