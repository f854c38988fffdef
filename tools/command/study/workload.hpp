#pragma once
#include <optional>
#include <string>
#include <vector>

#include "cli/options.hpp"
#include "study/pose_file.hpp"

namespace oncollide::tools {

struct WorkloadOptions {
    std::vector<std::string> what; ///< a scene, or two mesh files
    SceneOptions scene;
    bool use_poses = false;  ///< a pose file instead of generated poses
    std::string poses{};     ///< that file; empty: the set in the data folder, with its own meshes
    std::string distances{}; ///< of generated poses, as for make_workload()
    std::optional<int> count{};
    int every = 1;
};

/// The workload of a study: a scene in motion, or two meshes, of which the second takes one pose per frame.
class StudyWorkload {
public:
    /// Throws Error{usage} for options that contradict each other, and the errors of reading files.
    explicit StudyWorkload(const WorkloadOptions& options);

    Scene scene;
    std::string title;

    bool is_poses() const { return !poses_.empty(); }
    int frames() const { return frames_; }                 ///< number of frames to play
    int number(int frame) const { return frame * every_; } ///< of a played frame: the scene's frame, or the pose
    /// Moves the bodies to their poses in the played frame. A run starts with frame 0.
    void move(int frame);
    /// Whether the bodies collide in this frame, if the pose file states it.
    std::optional<bool> known(int frame) const;

private:
    void open_meshes(const WorkloadOptions& options);

    std::vector<KnownPose> poses_; ///< empty: the scene moves by itself
    Mover mover_;
    int every_ = 1, frames_ = 1;
};

} // namespace oncollide::tools
