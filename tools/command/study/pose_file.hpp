#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace oncollide::tools {

/// A pose of the second of two meshes (the first does not move), and known results.
struct KnownPose {
    Eigen::Isometry3d b;
    int kind = 0;      ///< how it was generated: a number in the file
    double offset = 0; ///< from touching along a direction, negative: inwards; relative to the first mesh's size
    std::optional<bool> colliding = {};
    std::optional<std::uint64_t> triangle_pairs = {}; ///< number of intersecting pairs
};

/// Reads poses: lines `kind offset R(9, row-major) T(3)`, numbers as hexadecimal floats.
/// Throws Error{no_input} or Error{bad_data} with path and line.
std::vector<KnownPose> read_poses(const std::filesystem::path& path);

/// Reads an exact result for each pose: lines `index colliding pairs`. Throws as read_poses().
void read_expected(const std::filesystem::path& path, std::vector<KnownPose>& poses);

/// Reads poses, and their results from `NAME_expected` if that file exists.
std::vector<KnownPose> read_known_poses(const std::filesystem::path& path);

/// The pose set of a data folder, with exact results: two meshes and 1,000 poses.
struct PoseSet {
    std::filesystem::path mesh_a, mesh_b, poses, expected;
};
PoseSet pose_set(const std::filesystem::path& data_folder);

} // namespace oncollide::tools
