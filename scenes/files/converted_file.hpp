#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace oncollide {

// Files of other formats, as convert_files() says. Private to scenes.

/// The extensions of convert_files().
const std::vector<std::string>& converted_extensions();
bool is_converted_file(const std::filesystem::path& path);
/// The bytes of the GLB file that the converter makes of the file. Throws the Error of the converter or of check_readable().
std::string converted_file(const std::filesystem::path& path);

} // namespace oncollide
