#pragma once
#include <filesystem>

#include "bench/broad/box_scenes.hpp"

namespace oncollide::tools {

/// Opens a recording in Broadmark's format and reads its initial frame; later frames are read on demand.
///
///     char[128] scene   char[128] type of objects   int32 N, frames, 0, 0   world: min, max
///     then frames + 1 times: N boxes: min, max        each vector is four floats, the last of them 0
/// Throws Error{no_input} if the file cannot be read, and Error{bad_data} naming the position if the header is invalid,
/// the file's size does not match the header, or a box is not finite or has min above max. All frames are checked here.
BoxScene open_aabbs(const std::filesystem::path& path);

} // namespace oncollide::tools
