#pragma once
#include <cstdio>
#include <filesystem>

// Writing files; each operating system has its own functions. Private to the library; Windows: windows/system_file.cpp.
namespace oncollide {

enum class FileUse {
    write,  ///< an existing file or device is overwritten
    create, ///< fails with EEXIST if the name exists, also as a link
};

/// Opens a file for writing bytes; child processes do not inherit it. Null: failed, see errno.
std::FILE* open_to_write(const std::filesystem::path& path, FileUse use);

/// Checks write permission of an existing file without opening it; false: see errno.
bool may_write(const std::filesystem::path& path);

/// True for a name that the system reserves for a device, as Windows reserves "NUL" in every folder. The status of a file
/// shows the devices of other systems.
bool is_reserved_for_device(const std::filesystem::path& path);

/// Gives an open file the owner and permissions of an existing one, as far as the system allows it.
void copy_permissions(const std::filesystem::path& from, std::FILE* to);

/// Renames a file, also over an existing one, at once: other processes see either file. False: see errno.
bool replace_file(const std::filesystem::path& file, const std::filesystem::path& target);

/// Removes a file; safe in signal handlers.
void remove_in_handler(const std::filesystem::path::value_type* name) noexcept;

/// A new file without a name, for reading and writing: it disappears however the program ends. (On Windows it has a
/// name until then.) In `folder` if that is one on a file system with such files, else in the system's folder for
/// temporary files. Null: errno says why.
std::FILE* open_nameless(const std::filesystem::path& folder = {});

/// The device that discards all text.
inline constexpr const char* null_device =
#ifdef _WIN32
    "NUL";
#else
    "/dev/null";
#endif

} // namespace oncollide
