#include <oncollide/scenes/files/tile_index.hpp>

#include <set>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/scenes/files/geometry_recipe.hpp>
#include <oncollide/scenes/files/json/json_fault.hpp>
#include <oncollide/scenes/files/json/json_node.hpp>

namespace oncollide {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view version_key = "oncollide_tiles";
constexpr int index_version = 1;
constexpr std::uintmax_t most_index_bytes = std::uintmax_t(1) << 30;

IndexedTile read_tile(const Node& node)
{
    node.only({"file", "bounds", "radius", "triangles", "vertices", "zero_area", "header"});
    IndexedTile tile;
    tile.file = node["file"].text();
    if (!is_cooked(tile.file)) node["file"].fail("must be a cooked file (.cooked)");
    const Node bounds = node["bounds"];
    if (bounds.size() != 2) bounds.fail("must be two points: [[min x, y, z], [max x, y, z]]");
    CookedOutline& outline = tile.outline;
    outline.bounds = {bounds[0].vector3(), bounds[1].vector3()};
    outline.radius = node["radius"].number();
    constexpr std::int64_t most = 0xffffffff;
    outline.triangles = static_cast<std::uint64_t>(node["triangles"].integer(1, most));
    outline.vertices = static_cast<std::uint64_t>(node["vertices"].integer(1, most));
    outline.zero_area = static_cast<std::uint64_t>(node["zero_area"].integer(0, most));
    outline.header_checksum = node["header"].natural();
    if (const char* why = why_not_outline(outline)) node.fail(why);
    return tile;
}

} // namespace

std::vector<IndexedTile> load_tile_index(const fs::path& path)
{
    const std::string file = path.string();
    const FileBytes bytes = read_large_file(path, most_index_bytes);
    const std::string_view text = without_byte_order_mark(bytes);
    JsonTape tape({file});
    try {
        if (const char* end = tape.read(text, 0); end != text.data() + text.size()) throw JsonFault{end};
    } catch (const JsonFault& fault) {
        explain_json(file, bytes, fault.where);
    }
    const Node root(tape);
    root.only({version_key, "tiles"});
    if (const std::int64_t version = root[version_key].integer(0, 1'000'000); version != index_version)
        root[version_key].fail(fmt::format("version {} of such indexes; this program reads version {}; cook the tiles "
                                           "again",
                                           version, index_version));
    const Node list = root["tiles"];
    if (!list.is_array()) list.fail("must be an array of tiles");
    std::vector<IndexedTile> tiles;
    std::set<std::string_view> files;
    for (const Node& node : list) {
        tiles.push_back(read_tile(node));
        if (!files.insert(node["file"].text()).second) node["file"].fail("is there twice");
    }
    return tiles;
}

void save_tile_index(const fs::path& path, const std::vector<IndexedTile>& tiles)
{
    OutputFile out(path);
    JsonWriter json(out);
    json.begin_object();
    json.line(), json.members(version_key, index_version);
    json.line(), json.key("tiles"), json.begin_array();
    for (const auto& [file, o] : tiles) {
        const auto point = [](const Eigen::Vector3d& p) { return Json{p.x(), p.y(), p.z()}; };
        const nlohmann::ordered_json entry = {{"file", file},
                                              {"bounds", {point(o.bounds.min), point(o.bounds.max)}},
                                              {"radius", o.radius},
                                              {"triangles", o.triangles},
                                              {"vertices", o.vertices},
                                              {"zero_area", o.zero_area},
                                              {"header", o.header_checksum}};
        json.line(2), json.raw(entry.dump());
    }
    json.line(), json.end_array();
    json.line(), json.end_object();
    out.write("\n");
    out.commit();
}

IndexedTile index_tile(const fs::path& folder, const std::string& file)
{
    return {file, CookedMesh(folder / path_of(file)).outline()};
}

void add_tiles(SceneBuilder& scene, const std::string& name, const fs::path& index, const BodyInit& like,
               const SceneReading& reading)
{
    const std::vector<IndexedTile> tiles = load_tile_index(index);
    scene.reserve(scene.size() + tiles.size());
    std::uint64_t flat = 0;
    for (const IndexedTile& tile : tiles) {
        const fs::path file = file_in(index.parent_path(), tile.file);
        GeometryData mesh = reading.on_demand ? GeometryData(std::make_shared<const CookedMesh>(file, tile.outline))
                                              : GeometryData(load_mesh(file));
        BodyInit body = like;
        body.name = fmt::format("{}/{}", name, file.stem().string());
        body.geometry = scene.add(body.name, std::move(mesh),
                                  Json{{"mesh", {{"file", portable_name(absolute_path(file))}}}}.dump());
        body.is_static = true;
        scene.add_body(std::move(body));
        flat += tile.outline.zero_area;
    }
    if (flat)
        scene.warnings().push_back(
            fmt::format("{}: {} triangle{} without area (kept)", name, flat, flat == 1 ? "" : "s"));
}

} // namespace oncollide
