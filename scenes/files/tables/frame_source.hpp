#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <oncollide/scenes/files/json/json_node.hpp>

namespace oncollide {

// Arrays of frames x rows x numbers, which are read while they are played. Private to the project.

/// The source of a frame's numbers.
class FrameSource {
public:
    virtual ~FrameSource() = default;
    std::uint64_t frames = 0, rows = 0;
    /// Reads the numbers of `count` rows from `first` on.
    virtual void read(std::uint64_t frame, std::uint64_t first, std::uint64_t count, std::vector<double>& numbers) = 0;
};

/// The place of an array.
struct FrameFile {
    std::filesystem::path file;
    std::string path; ///< within an HDF5 file; empty: a `.npy` file
};

/// The members "file" and "path" of an entry of a scene file. Throws Error{bad_data} for an unknown kind of file.
/// @param path  in HDF5 files, if the entry has none
FrameFile frame_file(const Node& entry, const std::filesystem::path& folder, const char* path);

/// @param row      numbers of a row
/// @param what     of the rows, for errors: "bodies"
/// @param most     rows of a frame; it must have one at least
/// Throws Error{no_input}, Error{bad_data}, and Error{usage} for a kind of file that this build cannot read.
std::unique_ptr<FrameSource> open_frames(const FrameFile& file, std::uint64_t row, const char* what,
                                         std::uint64_t most);
std::unique_ptr<FrameSource> open_hdf5_frames(const FrameFile& file, std::uint64_t row);

} // namespace oncollide
