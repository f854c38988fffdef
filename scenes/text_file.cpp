#include "text_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include <fcntl.h>
#include <unistd.h>

#include <fmt/format.h>

#include <oncollide/scenes/error.hpp>

namespace oncollide {

namespace {

namespace fs = std::filesystem;

struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

[[noreturn]] void refuse(const fs::path& path, std::string_view why)
{
    throw Error(ErrorKind::cannot_write, fmt::format("{}: cannot write: {}", path.string(), why));
}

/// Removes the file of that name unless it was renamed before.
struct Temporary {
    fs::path path;
    bool renamed = false;
    ~Temporary()
    {
        if (!renamed) ::unlink(path.c_str());
    }
};

} // namespace

void write_text(const fs::path& path, std::string_view text)
{
    std::error_code error;
    if (!path.has_filename()) refuse(path, "the file name is empty");
    if (fs::is_directory(path, error)) refuse(path, "it is a folder");
    const fs::path target = fs::exists(path, error) ? fs::canonical(path, error) : path; // writes through a link
    // The process id keeps two writers apart; O_EXCL never follows a link that waits there.
    const fs::path name = target.parent_path() / fmt::format(".{}.{}.part", target.filename().string(), ::getpid());
    const int descriptor = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0) refuse(path, std::strerror(errno));
    Temporary temporary{name};
    File file(::fdopen(descriptor, "wb"));
    if (std::fwrite(text.data(), 1, text.size(), file.get()) != text.size()) refuse(path, std::strerror(errno));
    // Some file systems report a full disk or quota only on closing.
    if (std::fclose(file.release()) != 0) refuse(path, std::strerror(errno));
    if (std::rename(name.c_str(), target.c_str()) != 0) refuse(path, std::strerror(errno));
    temporary.renamed = true;
}

} // namespace oncollide
