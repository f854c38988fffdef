#pragma once
#include <filesystem>
#include <string_view>

namespace oncollide {

/// Private to scenes. Writes `text` to a temporary name beside `path`, then renames it; on failure nothing is left
/// behind. Throws Error{cannot_write}.
void write_text(const std::filesystem::path& path, std::string_view text);

} // namespace oncollide
