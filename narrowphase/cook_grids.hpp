// Checks of cooked terrains and maps against their contents: part of check_cooked().
#pragma once
#include <cstddef>
#include <filesystem>

namespace oncollide {

/// Return the number of chunks. Throw Error{no_input} or Error{bad_data}.
std::size_t check_cooked_terrain(const std::filesystem::path& path);
std::size_t check_cooked_map(const std::filesystem::path& path);

} // namespace oncollide
