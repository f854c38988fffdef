#include <oncollide/base/files/random_access_file.hpp>

#include <cerrno>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace oncollide {

RandomAccessFile::RandomAccessFile(const std::filesystem::path& path)
    : file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC))
{
}

void RandomAccessFile::close()
{
    if (is_open()) ::close(int(file_)), file_ = none;
}

std::int64_t RandomAccessFile::size() const
{
    struct stat about;
    return is_open() && ::fstat(int(file_), &about) == 0 ? std::int64_t(about.st_size) : -1;
}

const char* RandomAccessFile::read(std::uint64_t offset, std::span<std::byte> out) const
{
    while (!out.empty()) {
        const ssize_t got = ::pread(int(file_), out.data(), out.size(), static_cast<off_t>(offset));
        if (got > 0)
            out = out.subspan(std::size_t(got)), offset += std::uint64_t(got);
        else if (got == 0)
            return "the file ends before it";
        else if (errno != EINTR)
            return "the disk cannot read it";
    }
    return nullptr;
}

} // namespace oncollide
