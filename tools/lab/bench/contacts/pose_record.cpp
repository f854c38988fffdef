#include "bench/contacts/pose_record.hpp"

#include <oncollide/scenes/files/scene_file.hpp>
#include <oncollide/scenes/files/tables/recording_file.hpp>

namespace oncollide::tools {

void PoseRecord::add(std::span<const Eigen::Isometry3d> poses)
{
    for (const Eigen::Isometry3d& pose : poses.subspan(1)) add_recorded(pose, numbers_);
}

void PoseRecord::save(const std::filesystem::path& path) const
{
    const std::filesystem::path poses = path.parent_path() / (path.stem().string() + "-poses.npy");
    save_recording(numbers_, scene_.size() - 1, poses);
    Scene played;
    played.name = path.stem().string();
    for (const Geometry& geometry : scene_.geometries) played.add(geometry.name, geometry.data, geometry.recipe);
    for (std::size_t i = 0; i < scene_.size(); ++i)
        played.add_body({.name = std::string(scene_.names[i]),
                         .geometry = scene_.geometry[i],
                         .pose = scene_.start_pose(i),
                         .is_static = scene_.is_static[i] != 0});
    played.record(open_recording(poses, "", 1));
    played.frames = static_cast<int>(played.recording->frames);
    save_scene(played, path);
}

} // namespace oncollide::tools
