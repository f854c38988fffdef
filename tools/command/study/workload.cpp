#include "study/workload.hpp"

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

#include "study/narrow_poses.hpp"

namespace oncollide::tools {
namespace {

namespace fs = std::filesystem;

void check_scene(const WorkloadOptions& o)
{
    if (o.use_poses || o.count || !o.distances.empty())
        usage(fmt::format("{}: --poses, --distances and --count need two meshes: MESH_A MESH_B", o.what[0]));
}

void check_meshes(const WorkloadOptions& o)
{
    if (o.what.size() > 2) usage(fmt::format("'{}': expected a scene or two meshes", o.what[2]));
    if (o.use_poses && o.poses.empty() == !o.what.empty())
        usage(o.what.empty() ? fmt::format("--poses {}: needs the two meshes that the poses are for", o.poses)
                             : "--poses: the data folder's poses have their own meshes; name a pose file or no "
                               "meshes");
    if (o.use_poses && !o.distances.empty()) usage("--distances: does not apply to the poses of a file");
    if (o.scene.bodies || o.scene.frames) usage("--bodies and --frames apply only to scenes; use --count for poses");
    check_range("--count", o.count.value_or(1), 1, 100'000);
}

} // namespace

StudyWorkload::StudyWorkload(const WorkloadOptions& o) : every_(o.every)
{
    check_range("--every", o.every, 1);
    if (o.what.empty() && !o.use_poses) usage("study: needs a scene or two meshes");
    if (o.what.size() == 1) {
        check_scene(o);
        SceneOptions one = o.scene;
        one.scene = o.what[0];
        scene = open_scene(one);
        must_be_rigid(scene, "accuracy");
        title = scene.name;
        frames_ = (scene.frames + every_ - 1) / every_;
    } else {
        check_meshes(o);
        open_meshes(o);
        frames_ = (int(poses_.size()) + every_ - 1) / every_;
    }
}

void StudyWorkload::open_meshes(const WorkloadOptions& o)
{
    fs::path poses = o.poses;
    std::vector<fs::path> files(o.what.begin(), o.what.end());
    if (files.empty()) {
        const PoseSet set = pose_set(data_folder(o.scene.data));
        files = {set.mesh_a, set.mesh_b}, poses = set.poses;
    }
    std::vector<GeometryId> meshes;
    for (const char* side : {"A", "B"}) {
        const fs::path& file = files[meshes.size()];
        meshes.push_back(scene.add(fmt::format("{} {}", side, file.stem().string()), load_mesh(file)));
    }
    const auto mesh = [&](std::size_t k) -> const Mesh& { return std::get<Mesh>(scene.geometries[k].data); };
    if (o.use_poses) {
        poses_ = read_known_poses(poses);
        if (o.count && std::size_t(*o.count) < poses_.size()) poses_.resize(std::size_t(*o.count));
    } else {
        const std::vector<double> percents = parse_distances(o.distances.empty() ? "0,0.1,1,5" : o.distances);
        const NarrowWorkload workload =
            make_workload(mesh(0), mesh(1), percents, std::size_t(o.count.value_or(100)), o.scene.seed.value_or(12345));
        for (const NarrowPose& pose : workload.poses) poses_.push_back(pose.known);
    }
    title = fmt::format("{} and {} in {} poses", files[0].stem().string(), files[1].stem().string(), poses_.size());
    scene.name = title, scene.frames = int(poses_.size());
    scene.add_body({.name = scene.geometries[0].name, .geometry = meshes[0], .is_static = true});
    scene.add_body({.name = scene.geometries[1].name, .geometry = meshes[1], .pose = poses_.front().b});
}

void StudyWorkload::move(int frame)
{
    if (poses_.empty())
        mover_.move(scene, number(frame));
    else
        scene.set_pose(SceneBodyId{1}, poses_[std::size_t(number(frame))].b);
}

std::optional<bool> StudyWorkload::known(int frame) const
{
    if (poses_.empty()) return std::nullopt;
    return poses_[std::size_t(number(frame))].colliding;
}

} // namespace oncollide::tools
