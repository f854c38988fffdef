#include <oncollide/base/files/random_access_file.hpp>

#include <algorithm>

#include <windows.h>

namespace oncollide {

namespace {

HANDLE handle_of(std::intptr_t file)
{
    return reinterpret_cast<HANDLE>(file);
}

} // namespace

RandomAccessFile::RandomAccessFile(const std::filesystem::path& path)
    : file_(reinterpret_cast<std::intptr_t>(CreateFileW(path.c_str(), GENERIC_READ,
                                                        FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, nullptr,
                                                        OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, nullptr)))
{
    static_assert(none == -1); // INVALID_HANDLE_VALUE
}

void RandomAccessFile::close()
{
    if (is_open()) CloseHandle(handle_of(file_)), file_ = none;
}

std::int64_t RandomAccessFile::size() const
{
    LARGE_INTEGER size{};
    return is_open() && GetFileSizeEx(handle_of(file_), &size) ? size.QuadPart : -1;
}

const char* RandomAccessFile::read(std::uint64_t offset, std::span<std::byte> out) const
{
    constexpr std::size_t most = std::size_t{1} << 30; // a DWORD
    while (!out.empty()) {
        OVERLAPPED place{};
        place.Offset = static_cast<DWORD>(offset), place.OffsetHigh = static_cast<DWORD>(offset >> 32);
        DWORD got = 0;
        const DWORD wanted = static_cast<DWORD>(std::min(out.size(), most));
        if (!ReadFile(handle_of(file_), out.data(), wanted, &got, &place))
            return GetLastError() == ERROR_HANDLE_EOF ? "the file ends before it" : "the disk cannot read it";
        if (got == 0) return "the file ends before it";
        out = out.subspan(got), offset += got;
    }
    return nullptr;
}

} // namespace oncollide
