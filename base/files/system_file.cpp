#include <oncollide/base/files/system_file.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace oncollide {

namespace fs = std::filesystem;

std::FILE* open_to_write(const fs::path& path, FileUse use)
{
#if defined(__GLIBC__)
    constexpr const char *write = "wbe", *create = "wbxe"; // "e": child processes do not inherit the file
#else
    constexpr const char *write = "wb", *create = "wbx";
#endif
    return std::fopen(path.c_str(), use == FileUse::create ? create : write);
}

bool may_write(const fs::path& path)
{
    return ::access(path.c_str(), W_OK) == 0;
}

bool is_reserved_for_device(const fs::path&)
{
    return false;
}

/// Changes the owner first: chown clears the set-user-ID and set-group-ID bits.
void copy_permissions(const fs::path& from, std::FILE* to)
{
    struct stat old {};
    if (::stat(from.c_str(), &old) != 0) return;
    const int file = ::fileno(to);
    const bool owned = ::fchown(file, old.st_uid, old.st_gid) == 0;
    [[maybe_unused]] const int ignored = ::fchmod(file, old.st_mode & (owned ? 07777 : 0777));
}

bool replace_file(const fs::path& file, const fs::path& target)
{
    return std::rename(file.c_str(), target.c_str()) == 0;
}

void remove_in_handler(const char* name) noexcept
{
    ::unlink(name);
}

std::FILE* open_nameless([[maybe_unused]] const fs::path& folder)
{
#ifdef O_TMPFILE
    std::error_code error;
    for (const auto& place : {folder, fs::temp_directory_path(error)}) {
        const int file = place.empty() ? -1 : ::open(place.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
        if (file >= 0) return ::fdopen(file, "w+b");
    }
#endif
    return std::tmpfile();
}

} // namespace oncollide
