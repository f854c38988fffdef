#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/scenes/files/deformation_entry.hpp>
#include <oncollide/scenes/files/geometry_recipe.hpp>
#include <oncollide/scenes/files/scene_pose.hpp>
#include <oncollide/scenes/recording.hpp>

namespace oncollide {

namespace {

namespace fs = std::filesystem;
using Entry = nlohmann::ordered_json; // keeps a body's keys in a readable order

Entry list(const Eigen::Vector3d& v)
{
    return {v.x(), v.y(), v.z()};
}

void add_walls(Entry& motion, const Aabb& walls)
{
    if (!walls.empty()) motion["walls"] = {list(walls.min), list(walls.max)};
}

Entry motion_entry(const Still&)
{
    return {};
}

Entry motion_entry(const Keyed& motion)
{
    Entry keys = Entry::array();
    for (const Keyed::Key& key : motion.keys) {
        const Eigen::Vector3d& p = key.position;
        const Eigen::Quaterniond& q = key.rotation;
        keys.push_back({key.time, p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()});
    }
    return {{"keys", std::move(keys)}};
}

Entry motion_entry(const Drift& motion)
{
    Entry drift = {{"velocity", list(motion.velocity)}, {"spin", list(motion.spin)}};
    add_walls(drift, motion.walls);
    return {{"drift", std::move(drift)}};
}

Entry motion_entry(const Jitter& motion)
{
    Entry jitter = {{"step", motion.step}, {"seed", motion.seed}, {"index", motion.index}};
    add_walls(jitter, motion.walls);
    return {{"jitter", std::move(jitter)}};
}

Entry body_entry(const Scene& scene, std::size_t i)
{
    const Eigen::Isometry3d pose = scene.start_pose(i);
    const Motion& motion = scene.motions[i];
    const BodyInit otherwise;
    Entry body;
    if (!scene.names[i].empty()) body["name"] = scene.names[i];
    body["geometry"] = scene.geometries[index(scene.geometry[i])].name;
    const Eigen::Isometry3d implied = default_pose(motion);
    // The position is omitted for keyed bodies whose keys give it.
    if (!std::holds_alternative<Keyed>(motion) ||
        !same_bits(Eigen::Vector3d(pose.translation()), implied.translation()))
        body["position"] = list(pose.translation());
    if (!same_bits(Eigen::Matrix3d(pose.linear()), implied.linear())) body["rotation"] = rotation_entry(pose.linear());
    if (scene.layers[i] != otherwise.layer) body["layer"] = scene.layers[i];
    if (scene.masks[i] != otherwise.mask) body["mask"] = scene.masks[i];
    if (scene.is_static[i]) body["static"] = true;
    if (!std::holds_alternative<Still>(motion))
        body["motion"] = std::visit([](const auto& m) { return motion_entry(m); }, motion);
    if (scene.groups[i] != otherwise.group) body["group"] = scene.groups[i];
    return body;
}

Entry recording_entry(const Recording& recording, const fs::path& folder)
{
    Entry entry = {{"file", portable_name(absolute_path(path_of(recording.file)).lexically_proximate(folder))}};
    if (!recording.path.empty()) entry["path"] = recording.path;
    if (recording.first) entry["first"] = recording.first;
    return entry;
}

/// How another entry refers to a body: by its name, or by its number if it has none.
Entry reference_to(const Scene& scene, std::uint32_t body)
{
    return scene.names[body].empty() ? Entry(body) : Entry(scene.names[body]);
}

/// Removes the files that a failed save has made.
struct Made {
    std::vector<fs::path> files;
    ~Made()
    {
        std::error_code ignored;
        for (const fs::path& file : files) fs::remove(file, ignored);
    }
};

/// One line per geometry, per body and per excluded pair.
void write_text(const Scene& scene, const fs::path& path, const std::vector<std::string>& made_files, OutputFile& file)
{
    fs::path folder = absolute_path(path).parent_path();
    JsonWriter json(file);
    const auto on_a_line = [&](const Entry& entry) { json.line(2), json.raw(entry.dump()); };
    json.begin_object(), json.schema(scene_schema, scene_schema_version);
    json.line(), json.key("name"), json.raw(Json(scene.name).dump());
    json.line(), json.members("frames", scene.frames);
    json.line(), json.key("geometries"), json.begin_object();
    for (std::size_t i = 0; i < scene.geometries.size(); ++i) {
        const std::string name = Json(scene.geometries[i].name).dump(); // refuses text that is not UTF-8
        json.line(2), json.raw_key(name);
        Json entry = entry_of(scene.geometries.at_rest(i), folder, made_files[i]);
        if (const Deformation* const deformation = scene.geometries.deformation(i))
            entry["deformation"] = entry_of(*deformation, folder, scene.geometries[i].name);
        json.raw(entry.dump());
    }
    json.line(), json.end_object();
    json.line(), json.key("bodies"), json.begin_array();
    for (std::size_t i = 0; i < scene.size(); ++i) on_a_line(body_entry(scene, i));
    json.line(), json.end_array();
    if (scene.recording) {
        json.line(), json.key("recording");
        json.raw(recording_entry(*scene.recording, folder).dump());
    }
    if (!scene.excluded.empty()) {
        json.line(), json.key("exclude"), json.begin_array();
        for (const ExcludedPair& pair : scene.excluded) {
            json.line(2), json.begin_array();
            json.raw(reference_to(scene, pair.a).dump()), json.raw(reference_to(scene, pair.b).dump());
            json.end_array();
        }
        json.line(), json.end_array();
    }
    json.line(), json.end_object();
    file.write("\n");
}

} // namespace

void save_scene(const Scene& scene, const fs::path& path)
{
    std::vector<std::string> made_files(scene.geometries.size());
    for (std::size_t i = 0; i < made_files.size(); ++i) {
        const bool terrain = std::holds_alternative<Terrain>(scene.geometries[i].data);
        made_files[i] = fmt::format("{}-{}.{}", path.stem().string(), i, terrain ? "npy" : "bt");
    }
    OutputFile file(path);
    try {
        write_text(scene, path, made_files, file);
    } catch (const Json::exception&) {
        throw Error(ErrorKind::cannot_write,
                    fmt::format("{}: cannot write: a name or a path in the scene is not UTF-8 text", path.string()));
    }
    Made made;
    for (std::size_t i = 0; i < made_files.size(); ++i) {
        const Geometry& geometry = scene.geometries[i];
        const OccupancyMap* map = std::get_if<OccupancyMap>(&geometry.data);
        const Terrain* terrain = std::get_if<Terrain>(&geometry.data);
        if ((!map && !terrain) || !geometry.recipe.empty()) continue;
        const fs::path made_file = path.parent_path() / path_of(made_files[i]);
        std::error_code ignored;
        const bool is_new = !fs::exists(made_file, ignored);
        map ? save_octomap(*map, made_file) : save_terrain(*terrain, made_file);
        if (is_new) made.files.push_back(made_file);
    }
    file.commit();
    made.files.clear();
}

} // namespace oncollide
