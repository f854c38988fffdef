#include <oncollide/base/files/system_file.hpp>

#include <cerrno>
#include <random>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <io.h>
#include <windows.h>

namespace oncollide {

namespace fs = std::filesystem;

namespace {

void set_errno(DWORD error)
{
    errno = std::error_code(static_cast<int>(error), std::system_category()).default_error_condition().value();
}

constexpr DWORD all_share = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;

/// A stream of an open handle, without translation of line ends. Closes the handle if that fails.
std::FILE* stream_of(HANDLE handle, const char* mode)
{
    if (handle == INVALID_HANDLE_VALUE) return set_errno(GetLastError()), nullptr;
    const int file = ::_open_osfhandle(reinterpret_cast<std::intptr_t>(handle), _O_BINARY | _O_NOINHERIT);
    if (file < 0) return CloseHandle(handle), nullptr;
    std::FILE* const stream = ::_fdopen(file, mode);
    if (!stream) ::_close(file);
    return stream;
}

} // namespace

std::FILE* open_to_write(const fs::path& path, FileUse use)
{
    return stream_of(CreateFileW(path.c_str(), GENERIC_WRITE, all_share, nullptr,
                                 use == FileUse::create ? CREATE_NEW : CREATE_ALWAYS, FILE_ATTRIBUTE_NORMAL, nullptr),
                     "wb");
}

bool may_write(const fs::path& path)
{
    const DWORD attributes = GetFileAttributesW(path.c_str());
    if (attributes == INVALID_FILE_ATTRIBUTES || !(attributes & FILE_ATTRIBUTE_READONLY)) return true;
    errno = EACCES;
    return false;
}

bool is_reserved_for_device(const fs::path& path)
{
    const HANDLE file = CreateFileW(path.c_str(), 0, all_share, nullptr, OPEN_EXISTING, 0, nullptr);
    if (file == INVALID_HANDLE_VALUE) return false;
    const bool device = GetFileType(file) == FILE_TYPE_CHAR;
    CloseHandle(file);
    return device;
}

/// A new file has the permissions of its folder.
void copy_permissions(const fs::path&, std::FILE*) {}

/// Virus scanners and indexers open a new file for a moment, and Windows does not replace an open file. The function
/// therefore tries again for about a second.
bool replace_file(const fs::path& file, const fs::path& target)
{
    constexpr DWORD how = MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH;
    for (DWORD wait = 1;; wait *= 2) {
        if (MoveFileExW(file.c_str(), target.c_str(), how)) return true;
        const DWORD error = GetLastError();
        set_errno(error);
        if ((error != ERROR_SHARING_VIOLATION && error != ERROR_ACCESS_DENIED) || wait > 512) return false;
        Sleep(wait);
    }
}

/// Windows runs handlers of Ctrl-C in a thread of their own, so that all functions are safe in them. The file is still
/// open, and its name vanishes at once only with the sharing of open_to_write().
void remove_in_handler(const wchar_t* name) noexcept
{
    DeleteFileW(name);
}

std::FILE* open_nameless(const fs::path& folder)
{
    std::error_code error;
    std::random_device random;
    for (const fs::path& place : {folder, fs::temp_directory_path(error)}) {
        if (place.empty()) continue;
        const fs::path name = place / fmt::format(".{:08x}{:08x}.part", random(), random());
        const HANDLE file = CreateFileW(name.c_str(), GENERIC_READ | GENERIC_WRITE, FILE_SHARE_DELETE, nullptr,
                                        CREATE_NEW, FILE_ATTRIBUTE_TEMPORARY | FILE_FLAG_DELETE_ON_CLOSE, nullptr);
        if (std::FILE* const stream = stream_of(file, "w+b")) return stream;
    }
    return nullptr;
}

} // namespace oncollide
