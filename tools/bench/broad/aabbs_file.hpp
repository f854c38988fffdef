#pragma once
#include <filesystem>

#include "bench/broad/box_scenes.hpp"

namespace oncollide::tools {

/// Opens a recording in Broadmark's format and reads its initial frame; later frames are read as they are needed.
///
///     char[128] scene   char[128] type of objects   int32 N, frames, 0, 0   world: min, max
///     then frames + 1 times: N boxes: min, max        each vector is four floats, the last of them 0
///
/// Throws Error{no_input} when the file cannot be read, Error{bad_data} naming the place when the header is not one,
/// the file is too short or too long for what it announces, or a box is not finite or upside down; of later frames too,
/// which are all checked here.
BoxScene open_aabbs(const std::filesystem::path& path);

} // namespace oncollide::tools
