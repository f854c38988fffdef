#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace oncollide::tools {

/// A pose of the second of two meshes (the first stays), and what is known about it.
struct KnownPose {
    Eigen::Isometry3d b;
    int kind = 0;      ///< how it was drawn: a number of the file
    double offset = 0; ///< along some direction from touching, negative into it, over the size of the first mesh
    std::optional<bool> colliding = {};
    std::optional<std::uint64_t> triangle_pairs = {}; ///< that intersect
};

/// Reads poses: lines `kind offset R(9, row-major) T(3)`, numbers as hexadecimal floats.
/// Throws Error{no_input} or Error{bad_data} with path and line.
std::vector<KnownPose> read_poses(const std::filesystem::path& path);

/// Reads an exact answer for each pose: lines `index colliding pairs`. Throws as read_poses.
void read_expected(const std::filesystem::path& path, std::vector<KnownPose>& poses);

/// Both: poses, and the answers in `NAME_expected` beside `NAME`, where there is such a file.
std::vector<KnownPose> read_known_poses(const std::filesystem::path& path);

/// The pose set of a data folder, with exact answers: two meshes and 1,000 poses.
struct PoseSet {
    std::filesystem::path mesh_a, mesh_b, poses, expected;
};
PoseSet pose_set(const std::filesystem::path& data_folder);

} // namespace oncollide::tools
