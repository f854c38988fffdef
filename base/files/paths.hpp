#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace oncollide {

// Replacements for functions of std::filesystem that throw exceptions of their own. These functions report every fault
// as an Error that names the path. tests/builds/throwing_paths.py refuses the throwing functions elsewhere.

/// The path that a text names. Texts of files are UTF-8 on every system. On Windows the constructor of
/// std::filesystem::path takes a text for another code page. Throws Error{no_input} if a name on Windows is not UTF-8.
std::filesystem::path path_of(std::string_view name);

/// The text that names a path in files that other systems may read: UTF-8, with '/' between folders.
std::string portable_name(const std::filesystem::path& path);

/// The path from the root; an empty one is the current folder. Throws Error{no_input} if the current folder was
/// removed, on which a relative path depends.
std::filesystem::path absolute_path(const std::filesystem::path& path);

/// `file` relative to `folder`, with links followed where the system allows it.
std::filesystem::path path_from(const std::filesystem::path& folder, const std::filesystem::path& file);

/// False for a path that does not exist, or that the system does not show.
bool is_folder(const std::filesystem::path& path);
bool is_regular(const std::filesystem::path& path);

/// Throws Error{no_input}.
std::uintmax_t bytes_of_file(const std::filesystem::path& path);

/// The folder for temporary files. Throws Error{cannot_write} unless TMPDIR, or /tmp, is one.
std::filesystem::path temporary_files();

/// True if a name begins with a scheme such as "http://". Only "file://" can name a file of this machine.
bool is_address(std::string_view name);

/// The path of the file `name`, as another file in `folder` refers to it; never standard input. "file://" may stand
/// before it. Throws Error{no_input} for any other address: nothing is read from a network.
std::filesystem::path file_in(const std::filesystem::path& folder, std::string_view name);

} // namespace oncollide
