#include <oncollide/base/files/spool.hpp>

#include <cerrno>
#include <cstring>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/system_file.hpp>

namespace oncollide {

namespace {

[[noreturn]] void fail()
{
    throw Error(ErrorKind::cannot_write,
                fmt::format("temporary file for results: cannot write: {}", std::strerror(errno)));
}

} // namespace

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
