#include <oncollide/runs/ranks/shared_file.hpp>

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/paths.hpp>

namespace oncollide {

SharedFile::~SharedFile()
{
    if (file_ >= 0) ::close(int(file_));
}

void SharedFile::fail(int error) const
{
    throw Error(ErrorKind::cannot_write, fmt::format("{}: cannot write: {}", path_.string(), std::strerror(error)));
}

void SharedFile::take_back(std::uint64_t size, const std::filesystem::path& than) const
{
    std::error_code error;
    if (std::filesystem::exists(part(), error) || !std::filesystem::is_regular_file(path_, error)) return;
    const bool newer = std::filesystem::last_write_time(path_, error) >= std::filesystem::last_write_time(than, error);
    if (error || !newer || std::filesystem::file_size(path_, error) < size) return;
    std::filesystem::copy_file(path_, part(), error);
    if (error) fail(error.value());
}

void SharedFile::create()
{
    const int file = ::open(part().c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file < 0) fail(errno);
    ::close(file);
}

void SharedFile::open()
{
    file_ = ::open(part().c_str(), O_RDWR | O_CLOEXEC);
    if (file_ < 0) fail(errno);
}

void SharedFile::write(std::uint64_t offset, std::string_view bytes)
{
    while (!bytes.empty()) {
        const ssize_t written = ::pwrite(int(file_), bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) fail(written < 0 ? errno : ENOSPC);
        bytes.remove_prefix(std::size_t(written)), offset += std::uint64_t(written);
    }
}

void SharedFile::truncate(std::uint64_t size)
{
    if (::ftruncate(int(file_), static_cast<off_t>(size)) != 0) fail(errno);
}

std::uint64_t SharedFile::size() const
{
    struct stat status {};
    if (::fstat(int(file_), &status) != 0) fail(errno);
    return std::uint64_t(status.st_size);
}

void SharedFile::sync()
{
    if (::fsync(int(file_)) != 0) fail(errno);
}

void SharedFile::rename()
{
    std::error_code error;
    std::filesystem::rename(part(), path_, error);
    if (error) fail(error.value());
    // fsync the folder, so the new name survives a power failure.
    const std::filesystem::path folder = absolute_path(path_).parent_path();
    if (const int directory = ::open(folder.c_str(), O_RDONLY | O_CLOEXEC); directory >= 0)
        ::fsync(directory), ::close(directory);
}

void SharedFile::remove() noexcept
{
    ::unlink(part().c_str());
}

} // namespace oncollide
