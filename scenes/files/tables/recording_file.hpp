#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include <oncollide/scenes/files/json/json_node.hpp>
#include <oncollide/scenes/recording.hpp>

namespace oncollide {

// Recorded motion: arrays of frames x bodies x (x, y, z, qx, qy, qz, qw). Private to scenes.

/// The recording that a scene file names. Throws Error{no_input}, Error{bad_data}, and Error{usage} for a kind of file
/// that this build cannot read.
std::shared_ptr<Recording> open_recording(const Node& entry, const std::filesystem::path& folder);

/// The source of a frame's numbers.
class PoseSource {
public:
    virtual ~PoseSource() = default;
    std::uint64_t frames = 0, bodies = 0;
    /// Reads seven numbers for each of `count` bodies from `first` on.
    virtual void read(std::uint64_t frame, std::uint64_t first, std::uint64_t count, std::vector<double>& numbers) = 0;
};

// One function per format.
std::unique_ptr<PoseSource> open_npy_poses(const std::filesystem::path& path);
std::unique_ptr<PoseSource> open_hdf5_poses(const std::filesystem::path& path, const std::string& dataset);

} // namespace oncollide
