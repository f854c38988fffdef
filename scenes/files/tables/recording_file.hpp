#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/scenes/files/json/json_node.hpp>
#include <oncollide/scenes/recording.hpp>

namespace oncollide {

// Recorded motion: arrays of frames x bodies x (x, y, z, qx, qy, qz, qw). Private to the project.

/// The recording that a scene file names. Throws Error{no_input}, Error{bad_data}, and Error{usage} for a kind of file
/// that this build cannot read.
std::shared_ptr<Recording> open_recording(const Node& entry, const std::filesystem::path& folder);
/// The recording of bodies from `first` on. Throws the same.
std::shared_ptr<Recording> open_recording(const std::filesystem::path& path, const std::string& dataset,
                                          std::uint32_t first);

/// Appends the numbers of a pose.
void add_recorded(const Eigen::Isometry3d& pose, std::vector<float>& numbers);
/// Writes the numbers of whole frames of `bodies` bodies as a `.npy` file (temporary name, then renamed). Throws
/// Error{cannot_write}.
void save_recording(std::span<const float> numbers, std::size_t bodies, const std::filesystem::path& path);

} // namespace oncollide
