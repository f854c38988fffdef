#pragma once
#include <optional>
#include <string>
#include <vector>

#include "bench/narrow/pose_file.hpp"
#include "cli/options.hpp"

namespace oncollide::tools {

struct WorkloadOptions {
    std::vector<std::string> what; ///< a scene, or two mesh files
    SceneOptions scene;
    bool use_poses = false; ///< a pose file instead of generated poses
    std::string poses;      ///< that file; empty: the data folder's, with its own meshes
    std::string distances;  ///< of generated poses, as make_workload() takes them
    std::optional<int> count;
    int every = 1;
};

/// What a study looks at: a scene as it moves, or two meshes, of which the second is put into one pose a frame.
class StudyWorkload {
public:
    /// Throws Error{usage} for options that make no sense together, and whatever reading files throws.
    explicit StudyWorkload(const WorkloadOptions& options);

    Scene scene;
    std::string title;

    bool is_poses() const { return !poses_.empty(); }
    int frames() const { return frames_; }                 ///< to be played
    int number(int frame) const { return frame * every_; } ///< of a frame played: the scene's frame, or the pose
    /// Puts the bodies where they are at the frame played. A run starts with frame 0.
    void move(int frame);
    /// Does the pose file say whether the bodies collide there?
    std::optional<bool> known(int frame) const;

private:
    void open_meshes(const WorkloadOptions& options);

    std::vector<KnownPose> poses_; ///< empty: the scene moves by itself
    Mover mover_;
    int every_ = 1, frames_ = 1;
};

} // namespace oncollide::tools
