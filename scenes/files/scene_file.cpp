#include <oncollide/scenes/files/scene_file.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/reading_progress.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/scenes/deformation.hpp>
#include <oncollide/scenes/files/common/quaternion.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/files/geometry_recipe.hpp>
#include <oncollide/scenes/files/json/json_fault.hpp>
#include <oncollide/scenes/files/json/json_node.hpp>
#include <oncollide/scenes/files/scene_pose.hpp>
#include <oncollide/scenes/files/tables/body_table.hpp>
#include <oncollide/scenes/files/tables/recording_file.hpp>
#include <oncollide/scenes/files/tile_index.hpp>

namespace oncollide {

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t most_scene_bytes = std::uintmax_t(2) << 30;

/// A mesh or a map instead of a scene file is a frequent mistake; an error about its JSON syntax would not help.
void refuse_other_files(const fs::path& path)
{
    std::string extension = lower_extension(path);
    if (extension.empty()) return;
    extension.erase(0, 1);
    const auto& meshes = mesh_extensions();
    const bool mesh = std::find(meshes.begin(), meshes.end(), extension) != meshes.end();
    if (!mesh && extension != "bt" && extension != "ot") return;
    throw Error(ErrorKind::bad_data, fmt::format("{}: is {}, not a scene file; write a scene (JSON) that names it",
                                                 path.string(), mesh ? "a mesh" : "an OctoMap"));
}

Aabb read_walls(const Node& node)
{
    Aabb walls;
    if (node.size() != 2) node.fail("must be two points: [[min x, y, z], [max x, y, z]]");
    walls.min = node[0].vector3();
    walls.max = node[1].vector3();
    if (walls.empty()) node.fail("the first point must not exceed the second one in any coordinate");
    return walls;
}

Keyed read_keys(const Node& node, std::vector<std::string>& warnings)
{
    Keyed motion;
    motion.keys.reserve(node.size());
    // row.place() takes linear time, and each row may need a warning.
    const auto place = [&] { return fmt::format("{}[{}]", node.place(), motion.keys.size()); };
    for (const Node& row : node) {
        Eigen::Matrix<double, 8, 1> n;
        row.numbers(8, n.data());
        motion.keys.push_back({n[0], n.segment<3>(1), quaternion_of(place, n.segment<4>(4), warnings)});
    }
    at(node, [&] { check_motion("motion", motion); });
    return motion;
}

Motion read_motion(const Node& node, const fs::path& folder, std::vector<std::string>& warnings)
{
    const std::string_view kind = node.one_of({"keys", "tum", "drift", "jitter"});
    const Node value = node[kind];
    if (kind == "keys") return read_keys(value, warnings);
    if (kind == "tum") {
        value.only({"file", "frames_per_second"});
        const double rate = value["frames_per_second"].number();
        return at(value, [&] { return load_tum(file_in(folder, value["file"].text()), rate, warnings); });
    }
    if (kind == "drift") {
        const auto [velocity, spin, walls] = value.members("velocity", "spin", "walls");
        Drift drift;
        if (velocity) drift.velocity = velocity->vector3();
        if (spin) drift.spin = spin->vector3();
        if (walls) drift.walls = read_walls(*walls);
        return drift;
    }
    value.only({"step", "seed", "index", "walls"});
    return Jitter{.step = value["step"].number(),
                  .seed = value.has("seed") ? value["seed"].natural() : 0,
                  .index = value.has("index") ? value["index"].natural() : 0,
                  .walls = value.has("walls") ? read_walls(value["walls"]) : Aabb()};
}

std::uint32_t read_u32(const std::optional<Node>& node, std::uint32_t otherwise)
{
    return node ? static_cast<std::uint32_t>(node->integer(0, 0xffffffff)) : otherwise;
}

std::vector<std::string_view> names_of(const GeometryList& geometries)
{
    std::vector<std::string_view> names;
    for (const auto& geometry : geometries) names.push_back(geometry.name);
    return names;
}

GeometryId read_reference(const Node& node, const SceneBuilder& scene)
{
    const GeometryList& geometries = scene.geometries();
    const std::string_view name = node.text();
    if (const std::optional<GeometryId> found = scene.find_geometry(name)) return *found;
    constexpr std::size_t most = 20;
    std::string names;
    for (std::size_t i = 0; i < std::min(most, geometries.size()); ++i) names += (i ? ", " : "") + geometries[i].name;
    if (geometries.size() > most) names += fmt::format(" and {} more", geometries.size() - most);
    const std::string hint = did_you_mean(name, names_of(geometries));
    node.fail(fmt::format("no geometry named '{}'{} this scene has: {}", name, hint.empty() ? ";" : hint,
                          names.empty() ? "none" : names));
}

void read_body(SceneBuilder& scene, const Node& node, const fs::path& folder)
{
    const auto [name, geometry, position, rotation, layer, mask, is_static, motion, group] =
        node.members("name", "geometry", "position", "rotation", "layer", "mask", "static", "motion", "group");
    BodyInit body;
    if (name) body.name = name->text();
    body.geometry = read_reference(geometry ? *geometry : node["geometry"], scene);
    if (motion) body.motion = read_motion(*motion, folder, scene.warnings());
    body.pose = default_pose(body.motion);
    if (position) body.pose.translation() = position->vector3();
    if (rotation) body.pose.linear() = read_rotation(*rotation, scene.warnings());
    body.is_static = is_static && is_static->boolean();
    body.layer = read_u32(layer, body.layer);
    body.mask = read_u32(mask, body.mask);
    body.group = read_u32(group, body.group);
    at(node, [&] { scene.add_body(std::move(body)); });
}

SceneBodyId read_body_reference(const Node& node, const SceneBuilder& scene)
{
    if (node.is_text()) {
        const std::string_view name = node.text();
        if (name.empty()) node.fail("is empty; a body without a name goes by its number in 'bodies'");
        if (const std::optional<SceneBodyId> found = scene.find(name)) return *found;
        node.fail(fmt::format("no body named '{}'", name));
    }
    if (!node.is_number()) node.fail("must be the name of a body, or its number in 'bodies'");
    if (scene.size() == 0) node.fail("the scene has no bodies");
    return SceneBodyId{static_cast<std::uint32_t>(node.integer(0, static_cast<std::int64_t>(scene.size()) - 1))};
}

void read_excluded(SceneBuilder& scene, const Node& list)
{
    if (list.size() == 0) return; // size() throws for any other kind of node
    for (const Node& pair : list) {
        if (pair.size() != 2) pair.fail(fmt::format("has {} bodies, must have two", pair.size()));
        const SceneBodyId a = read_body_reference(pair[0], scene), b = read_body_reference(pair[1], scene);
        at(pair, [&] { scene.exclude(a, b); });
    }
}

/// The text of a scene file: bodies are put one after the other on their own tape, the rest on another.
class SceneText {
public:
    /// Throws JsonFault.
    SceneText(std::string_view file, std::string_view text) : rest_({file}), body_({file, "bodies"})
    {
        const char* const end = rest_.read(text, 0, "bodies");
        if (end != text.data() + text.size()) throw JsonFault{end};
    }

    Node root() const { return Node(rest_); }

    /// Calls visit(node) for each body. Throws JsonFault.
    template <class Visit>
    void each_body(Visit visit)
    {
        const Node root = this->root();
        if (!root.has("bodies") || !root["bodies"].is_array()) return;
        const std::string_view bodies = root["bodies"].source();
        ReadingProgress progress(rest_.place.file, bodies.size());
        each_element(bodies, 1, body_, [&](const JsonTape& body) {
            progress.at(static_cast<std::uint64_t>(body.values().front().source - bodies.data()));
            visit(Node(body));
        });
    }

private:
    JsonTape rest_, body_;
};

void reserve(SceneBuilder& scene, const Node& bodies)
{
    if (bodies.size() > most_bodies)
        bodies.fail(fmt::format("{} bodies, at most {} are allowed", bodies.size(), most_bodies));
    // Least bytes of a body, so that a list of commas cannot reserve much memory.
    constexpr std::size_t least_bytes = 16;
    scene.reserve(std::min(bodies.size(), bodies.source().size() / least_bytes));
}

void read_tables(SceneBuilder& scene, const Node& tables, const fs::path& folder)
{
    if (!tables.is_array()) tables.fail("must be an array of objects with the keys: file, path, geometry");
    for (const Node& table : tables) at(table, [&] { read_body_table(scene, table, folder); });
}

void read_tiles(SceneBuilder& scene, const Node& sets, const fs::path& folder, const SceneReading& reading)
{
    if (!sets.is_array()) sets.fail("must be an array of objects with the key: file");
    for (const Node& node : sets) {
        const auto [file, own_name, position, rotation, layer, mask, group] =
            node.members("file", "name", "position", "rotation", "layer", "mask", "group");
        BodyInit like;
        if (position) like.pose.translation() = position->vector3();
        if (rotation) like.pose.linear() = read_rotation(*rotation, scene.warnings());
        like.layer = read_u32(layer, like.layer);
        like.mask = read_u32(mask, like.mask);
        like.group = read_u32(group, like.group);
        const std::string name(own_name ? own_name->text() : "tiles");
        at(node, [&] { add_tiles(scene, name, file_in(folder, node["file"].text()), like, reading); });
    }
}

/// True if bodies are given by name. True if all names must be stored.
bool excludes_names(const Node& root)
{
    if (!root.has("exclude")) return false;
    for (const Node& pair : root["exclude"])
        for (const Node& body : pair)
            if (body.is_text()) return true;
    return false;
}

/// The length of the longest recording; 1 without any.
int frames_of_recordings(const SceneInfo& info)
{
    std::uint64_t frames = info.recording ? info.recording->frames : 1;
    for (const std::uint32_t g : info.geometries.deforming())
        frames = std::max(frames, info.geometries.deformation(g)->frames);
    return static_cast<int>(std::min<std::uint64_t>(frames, 1'000'000'000));
}

void read_scene(SceneText& text, const fs::path& path, const SceneReading& reading, SceneInfo& info, SceneBuilder scene)
{
    const Node root = text.root();
    info.name = root.has("name") ? std::string(root["name"].text()) : path.stem().string();
    if (root.has("frames")) info.frames = static_cast<int>(root["frames"].integer(1, 1'000'000'000));
    const fs::path folder = path.parent_path();
    const Node geometries = root["geometries"];
    if (!geometries.is_object()) geometries.fail("must be an object: a name and a geometry for each");
    Expansion expansion;
    for (const Node& geometry : geometries)
        expansion.count(info.geometries[index(add_geometry(info, geometry.key(), geometry, folder, reading))],
                        geometry);
    if (root.has("bodies") || !(root.has("tables") || root.has("tiles"))) reserve(scene, root["bodies"]);
    text.each_body([&](const Node& body) {
        if (!scene.skip_body()) read_body(scene, body, folder);
    });
    if (root.has("tables")) read_tables(scene, root["tables"], folder);
    if (root.has("tiles")) read_tiles(scene, root["tiles"], folder, reading);
    if (root.has("recording")) {
        const Node entry = root["recording"];
        at(entry, [&] { scene.record(open_recording(entry, folder)); });
    }
    if (!root.has("frames")) info.frames = frames_of_recordings(info);
    if (root.has("exclude")) read_excluded(scene, root["exclude"]);
}

/// Files without a schema are valid.
void check_schema(const Node& root)
{
    if (!root.is_object()) return;
    if (root.has("schema") && root["schema"].text() != scene_schema)
        root["schema"].fail(fmt::format("is '{}'; a scene has '{}'", root["schema"].text(), scene_schema));
    if (root.has("schema_version") && root["schema_version"].integer(1, 1'000'000) != scene_schema_version)
        root["schema_version"].fail(fmt::format("is {}; this version of oncollide reads {}",
                                                root["schema_version"].source(), scene_schema_version));
}

/// Opens the file and calls read(text).
template <class Read>
void read_scene_file(const fs::path& path, Read read)
{
    const std::string file = path == "-" ? "standard input" : path.string();
    std::error_code ignored;
    if (fs::is_regular_file(path, ignored)) refuse_other_files(path);
    const FileBytes bytes = read_large_file(path, most_scene_bytes);
    const std::string_view json = without_byte_order_mark(bytes);
    try {
        SceneText text(file, json);
        try {
            check_schema(text.root());
            text.root().only({"name", "frames", "geometries", "bodies", "tables", "tiles", "recording", "exclude",
                              "schema", "schema_version"});
            read(text);
        } catch (const Error&) {
            text.each_body([](const Node&) {}); // reports JSON errors before other errors
            throw;
        }
    } catch (const JsonFault& fault) {
        explain_json(file, bytes, fault.where);
    }
}

} // namespace

Scene load_scene(const fs::path& path, const SceneReading& reading)
{
    Scene scene;
    read_scene_file(path, [&](SceneText& text) { read_scene(text, path, reading, scene, scene); });
    return scene;
}

SceneInfo load_scene(const fs::path& path, BodySink& sink, const SceneReading& reading)
{
    SceneInfo info;
    read_scene_file(path, [&](SceneText& text) {
        if (!excludes_names(text.root())) return read_scene(text, path, reading, info, {info, sink});
        Scene scene;
        read_scene(text, path, reading, scene, scene);
        pass_bodies(scene, sink);
        info = std::move(scene);
    });
    return info;
}

} // namespace oncollide
