#include <oncollide/runs/ranks/shared_file.hpp>

#include <algorithm>
#include <system_error>

#include <fmt/format.h>
#include <windows.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/system_file.hpp>

namespace oncollide {

namespace {

HANDLE handle_of(std::intptr_t file)
{
    return reinterpret_cast<HANDLE>(file);
}

HANDLE open_shared(const std::filesystem::path& path, DWORD how)
{
    return CreateFileW(path.c_str(), GENERIC_READ | GENERIC_WRITE,
                       FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, nullptr, how, FILE_ATTRIBUTE_NORMAL,
                       nullptr);
}

} // namespace

SharedFile::~SharedFile()
{
    if (file_ != -1) CloseHandle(handle_of(file_));
}

/// @param error  of GetLastError()
void SharedFile::fail(int error) const
{
    throw Error(ErrorKind::cannot_write,
                fmt::format("{}: cannot write: {}", path_.string(), std::system_category().message(error)));
}

void SharedFile::take_back(std::uint64_t size, const std::filesystem::path& than) const
{
    std::error_code error;
    if (std::filesystem::exists(part(), error) || !std::filesystem::is_regular_file(path_, error)) return;
    const bool newer = std::filesystem::last_write_time(path_, error) >= std::filesystem::last_write_time(than, error);
    if (error || !newer || std::filesystem::file_size(path_, error) < size) return;
    if (!CopyFileW(path_.c_str(), part().c_str(), TRUE)) fail(int(GetLastError()));
}

void SharedFile::create()
{
    const HANDLE file = open_shared(part(), OPEN_ALWAYS);
    if (file == INVALID_HANDLE_VALUE) fail(int(GetLastError()));
    CloseHandle(file);
}

void SharedFile::open()
{
    file_ = reinterpret_cast<std::intptr_t>(open_shared(part(), OPEN_EXISTING));
    if (file_ == -1) fail(int(GetLastError()));
}

void SharedFile::write(std::uint64_t offset, std::string_view bytes)
{
    while (!bytes.empty()) {
        OVERLAPPED place{};
        place.Offset = static_cast<DWORD>(offset), place.OffsetHigh = static_cast<DWORD>(offset >> 32);
        const DWORD piece = static_cast<DWORD>(std::min<std::size_t>(bytes.size(), std::size_t{1} << 30));
        DWORD written = 0;
        if (!WriteFile(handle_of(file_), bytes.data(), piece, &written, &place)) fail(int(GetLastError()));
        if (written == 0) fail(ERROR_DISK_FULL);
        bytes.remove_prefix(written), offset += written;
    }
}

void SharedFile::truncate(std::uint64_t size)
{
    LARGE_INTEGER end{};
    end.QuadPart = static_cast<LONGLONG>(size);
    if (!SetFilePointerEx(handle_of(file_), end, nullptr, FILE_BEGIN) || !SetEndOfFile(handle_of(file_)))
        fail(int(GetLastError()));
}

std::uint64_t SharedFile::size() const
{
    LARGE_INTEGER size{};
    if (!GetFileSizeEx(handle_of(file_), &size)) fail(int(GetLastError()));
    return std::uint64_t(size.QuadPart);
}

void SharedFile::sync()
{
    if (!FlushFileBuffers(handle_of(file_))) fail(int(GetLastError()));
}

/// The rename is on the disk when it returns.
void SharedFile::rename()
{
    if (!replace_file(part(), path_)) fail(int(GetLastError()));
}

void SharedFile::remove() noexcept
{
    DeleteFileW(part().c_str());
}

} // namespace oncollide
