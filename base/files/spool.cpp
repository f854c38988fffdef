#include <oncollide/base/files/spool.hpp>

#include <cerrno>
#include <cstring>

#include <oncollide/base/error.hpp>

#if __has_include(<unistd.h>)
#include <fcntl.h>
#include <unistd.h>
#endif

namespace oncollide {

namespace {

[[noreturn]] void fail()
{
    throw Error(ErrorKind::cannot_write,
                fmt::format("temporary file for results: cannot write: {}", std::strerror(errno)));
}

} // namespace

std::FILE* open_nameless([[maybe_unused]] const std::filesystem::path& folder)
{
#ifdef O_TMPFILE
    std::error_code error;
    for (const auto& place : {folder, std::filesystem::temp_directory_path(error)}) {
        const int file = place.empty() ? -1 : ::open(place.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
        if (file >= 0) return ::fdopen(file, "w+b");
    }
#endif
    return std::tmpfile();
}

void Spool::flush()
{
    if (!file_) file_.reset(open_nameless(folder_));
    if (!file_ || std::fwrite(buffer_.data(), 1, buffer_.size(), file_.get()) != buffer_.size()) fail();
    buffer_.clear();
}

void Spool::read(const std::function<void(std::string_view)>& take) const
{
    if (file_) {
        std::FILE* const file = file_.get();
        if (std::fflush(file) != 0 || std::fseek(file, 0, SEEK_SET) != 0) fail();
        char piece[1 << 16];
        for (std::size_t count; (count = std::fread(piece, 1, sizeof piece, file)) > 0;) take({piece, count});
        if (std::ferror(file) || std::fseek(file, 0, SEEK_END) != 0) fail();
    }
    take({buffer_.data(), buffer_.size()});
}

} // namespace oncollide
