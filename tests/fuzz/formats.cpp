#include "formats.hpp"
#include "load_with_samples.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "bench/broad/aabbs_file.hpp"
#include "cooked_bytes.hpp"
#include "cooked_inputs.hpp"
#include "study/pose_file.hpp"
#ifdef ONCOLLIDE_HDF5
#include "hdf5_inputs.hpp"
#endif
#include "robot/planning_problem.hpp"
#include "robot/sphere_files.hpp"
#include "scenes/files/xml_writers.hpp"
#include "seeds.hpp"
#include "tools/run_command.hpp"
#include <oncollide/base/error.hpp>
#include <oncollide/base/rigid.hpp>
#include <oncollide/robots/robot.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/files/scene_file.hpp>
#include <oncollide/scenes/files/tile_index.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>
#include <oncollide/scenes/scene_builder.hpp>

namespace oncollide::test {

namespace {

namespace fs = std::filesystem;

constexpr Format all_formats[] = {
    {"obj", "input.obj", obj_seeds},
    {"off", "input.off", off_seeds},
    {"ply", "input.ply", ply_seeds},
    {"stl", "input.stl", stl_seeds},
    {"gltf", "input.gltf", gltf_seeds},
    {"glb", "input.glb", glb_seeds},
#ifdef ONCOLLIDE_XML
    {"dae", "input.dae", dae_seeds},
    {"3mf", "input.3mf", threemf_seeds},
    {"urdf", "input.urdf", urdf_seeds},
    {"srdf", "input.srdf", srdf_seeds},
    {"mjcf", "input.xml", mjcf_seeds},
#endif
#ifdef ONCOLLIDE_YAML
    {"problem", "scene.yaml", problem_seeds},
    {"request", "request.yaml", request_seeds},
#ifdef ONCOLLIDE_XML
    {"spheres", "input.yml", sphere_model_seeds},
#endif
#endif
    {"bt", "input.bt", bt_seeds},
    {"ot", "input.ot", ot_seeds},
    {"scene", "input.json", scene_seeds},
    {"pgm", "input.pgm", pgm_seeds},
    {"png", "input.png", png_seeds},
    {"npy", "input.npy", npy_seeds},
    {"poses", "input.poses", poses_seeds},
    {"aabbs", "input.aabbs", aabbs_seeds},
    {"table", "input.csv", table_seeds},
    {"recording", "recorded.npy", recording_seeds},
    {"vertices", "moved.npy", vertices_seeds},
    {"cooked", "input.cooked", cooked_seeds, mutated_cooked}, // with checksums that match any contents
    {"damaged", "input.cooked", cooked_seeds, mutated_cooked},
    {"tiles", "tiles.json", tiles_seeds},
#ifdef ONCOLLIDE_HDF5
    {"hdf5", "input.h5", hdf5_seeds, mutated_hdf5},
#endif
};

/// The guarantees of make_mesh.
void check(const Mesh& mesh)
{
    if (mesh.triangles.empty()) fault("a mesh without triangles");
    for (const auto& v : mesh.vertices)
        if (!v.allFinite()) fault("a vertex that is not finite");
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t)
            if (v >= mesh.vertices.size()) fault("a vertex number out of range");
}

void check(const OccupancyMap& map)
{
    if (map.count() == 0 || !map.bounds().min.allFinite() || !map.bounds().max.allFinite())
        fault("a map without bounds");
}

void check(const Scene& scene)
{
    for (const Geometry& geometry : scene.geometries)
        if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) check(*mesh);
    for (const auto& pose : scene.poses)
        if (!why_not_rigid(pose).empty()) fault("a pose that is not rigid");
}

/// A tree, as Robot requires it.
void check(const RobotDescription& robot)
{
    for (const RobotJoint& joint : robot.joints)
        if (joint.parent >= robot.links.size() || joint.child >= robot.links.size()) fault("a joint without its link");
    for (const RobotLink& link : robot.links)
        for (const LinkGeometry& collision : link.collision) {
            if (!why_not_rigid(collision.pose).empty()) fault("a pose that is not rigid");
            if (const auto* mesh = std::get_if<Mesh>(&collision.geometry->data)) check(*mesh);
        }
    for (const auto& [a, b] : robot.excluded)
        if (a >= b || b >= robot.links.size()) fault("an excluded pair out of range");
    for (const RobotState& state : robot.states)
        for (const RobotState::Value& value : state.values)
            if (value.joint >= robot.joints.size()) fault("a state of no joint");
    if (std::ranges::any_of(robot.links, [](const RobotLink& link) { return !link.collision.empty(); })) {
        World world;
        const Robot made(world, robot);
        std::vector<Eigen::Isometry3d> poses(robot.links.size());
        made.link_poses(made.neutral(), poses);
    }
}

/// As they are read from scene.yaml and request.yaml; of one, the other is good.
void check(const tools::PlanningProblem& problem)
{
    for (const auto& obstacle : problem.obstacles)
        if (!why_not_rigid(obstacle.pose).empty()) fault("a pose that is not rigid");
    for (const auto* values : {&problem.start, &problem.goal})
        for (const auto& [joint, value] : *values)
            if (!std::isfinite(value)) fault("a joint that is not finite");
}

void check(const tools::SphereModel& model)
{
    for (const auto& spheres : model)
        for (const CoverSphere& sphere : spheres)
            if (!sphere.centre.allFinite() || !(sphere.radius > 0)) fault("a sphere that is none");
}

/// Opens each tile that exists, as an approaching body would.
void load_tiles(const fs::path& file)
{
    Scene scene;
    SceneBuilder builder(scene);
    add_tiles(builder, "tiles", file, {}, {.on_demand = true});
    check(scene);
    for (const Geometry& geometry : scene.geometries) {
        const auto& tile = std::get<std::shared_ptr<const CookedMesh>>(geometry.data);
        try {
            if (tile->open()->chunks.empty()) fault("a tile without chunks");
            check(tile->whole());
        } catch (const ChunkFault&) {
            if (tile->faults().size() != 1) fault("a tile does not report its fault");
        }
    }
}

void check(const Error& error, const fs::path& file);

void load(const fs::path& file)
{
    const std::string ending = file.extension();
    if (file.filename() == "tiles.json") return load_tiles(file);
    if (ending == ".json") {
        check(test::load_with_samples(file));
#ifdef ONCOLLIDE_HDF5
    } else if (ending == ".h5") {
        read_hdf5(file, [](const Error& error, const fs::path& of) { check(error, of); });
#endif
    } else if (ending == ".urdf" || ending == ".xml") {
        check(load_robot(file));
    } else if (ending == ".srdf") {
        check(load_robot(file.parent_path() / "arm.urdf", {.srdf = file}));
#ifdef ONCOLLIDE_YAML
    } else if (ending == ".yaml") {
        const fs::path folder = file.parent_path();
        const bool scene = file.filename() == "scene.yaml";
        check(tools::read_problem(scene ? file : folder / "good-scene.yaml",
                                  scene ? folder / "good-request.yaml" : file));
    } else if (ending == ".yml") {
        std::vector<std::string> warnings;
        check(tools::read_yaml_spheres(file, load_robot(file.parent_path() / "arm.urdf"), warnings));
#endif
    } else if (ending == ".csv") {
        check(test::load_with_samples(file.parent_path() / "table.json"));
    } else if (file.filename() == "recorded.npy" || file.filename() == "moved.npy") {
        Scene scene = test::load_with_samples(file.parent_path() /
                                              (file.filename() == "moved.npy" ? "deforming.json" : "recorded.json"));
        Mover mover;
        for (int frame = 0; frame < std::min(scene.frames, 5); ++frame) mover.move(scene, frame), check(scene);
    } else if (ending == ".bt" || ending == ".ot") {
        check(load_octomap(file));
        check(load_octomap(file, {.unknown_is_occupied = true}));
    } else if (ending == ".pgm" || ending == ".png" || ending == ".npy") {
        check(mesh_of(load_terrain(file, {.no_data = 7})));
    } else if (ending == ".poses") {
        auto poses = tools::read_poses(file);
        tools::read_expected(file.parent_path() / "expected", poses);
    } else if (ending == ".aabbs") {
        tools::open_aabbs(file);
    } else {
        check(load_mesh(file));
        if (!is_assembly_file(file)) return;
        for (const auto& mesh : load_assembly(file).meshes)
            if (mesh) check(std::get<Mesh>(mesh->data));
    }
}

void check(const Error& error, const fs::path& file)
{
    const std::string message = error.what();
    if (error.kind() != ErrorKind::bad_data && error.kind() != ErrorKind::no_input)
        fault("an error of another kind than bad_data and no_input: " + message);
    if (message.find(file.parent_path().string()) == message.npos) fault("a message without the file: " + message);
    if (std::any_of(message.begin(), message.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
        fault("a message that is not one line: " + message);
}

} // namespace

std::span<const Format> formats()
{
    return all_formats;
}

const Format& format_named(std::string_view name)
{
    for (const Format& format : all_formats)
        if (name == format.name) return format;
    std::fprintf(stderr, "no format named '%.*s'\n", int(name.size()), name.data());
    std::exit(64);
}

void fault(const std::string& what)
{
    std::fprintf(stderr, "contract broken: %s\n", what.c_str());
    std::abort();
}

void write_bytes(const fs::path& file, std::string_view bytes)
{
    std::FILE* const out = std::fopen(file.c_str(), "wb");
    if (!out) fault("the temporary folder cannot be written");
    const std::size_t written = std::fwrite(bytes.data(), 1, bytes.size(), out);
    if (std::fclose(out) != 0 || written != bytes.size()) fault("the temporary folder is full");
}

bool load_bytes(const Format& format, std::string_view bytes)
{
    const std::string_view name = format.name;
    const bool sealed = name == "cooked";
    static const TemporaryFolder folder;
    static const bool ready = (add_companions(folder), true);
    (void)ready;
    const fs::path file = folder / format.file;
    write_bytes(file, sealed ? resealed(std::string(bytes)) // reaches the code behind the checksums
                      : name == "3mf" && !bytes.starts_with("P") ? as_3mf(std::string(bytes))
                                                                 : std::string(bytes));
    try {
        if (format.mutated == mutated_cooked)
            query_cooked(file, sealed);
        else
            load(file);
        return true;
    } catch (const Error& error) {
        check(error, file);
        return false;
    }
}

} // namespace oncollide::test
