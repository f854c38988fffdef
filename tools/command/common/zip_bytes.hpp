#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace oncollide::tools {

/// A zip archive of files, each a name and its bytes, made by libzip.
/// @param time  the time of all files, seconds since 1970
/// Throws Error{internal}; in a build without libzip Error{usage}.
std::string zip_bytes(const std::vector<std::pair<std::string, std::string>>& files, std::int64_t time);

/// The version of libzip; "" in a build without it.
std::string zip_version();

/// Throws as zip_bytes in a build without libzip.
/// @param option  the option that needs libzip
void check_zip(const std::string& option);

} // namespace oncollide::tools
