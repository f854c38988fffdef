#include <oncollide/base/error.hpp>
#include <oncollide/base/output_file.hpp>

#include <cerrno>
#include <cstring>
#include <random>
#include <utility>

#if __has_include(<unistd.h>)
#include <unistd.h>
#endif

namespace oncollide {
namespace {

namespace fs = std::filesystem;

#if defined(__GLIBC__)
constexpr const char *write_only = "wbe", *create = "wbxe"; // "e": programs that we start do not inherit it
#else
constexpr const char *write_only = "wb", *create = "wbx";
#endif

[[noreturn]] void refuse(const fs::path& path, const std::string& why)
{
    throw Error(ErrorKind::cannot_write, fmt::format("{}: cannot write: {}", path.string(), why));
}

/// Whether what exists there may be written, without opening it. Where the system cannot say, opening it will.
bool may_write([[maybe_unused]] const fs::path& path)
{
#if __has_include(<unistd.h>)
    return ::access(path.c_str(), W_OK) == 0;
#else
    return true;
#endif
}

std::FILE* open(const fs::path& path, const char* how)
{
    return std::fopen(path.string().c_str(), how);
}

/// What `path` stands for: links followed, checked as far as that can be done without opening anything.
struct Target {
    fs::path path;
    bool in_place; ///< a device or a pipe, which a rename would replace by a plain file
};

Target resolve(const fs::path& path)
{
    if (path.empty()) refuse("(no name)", "the file name is empty");
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (fs::is_directory(status)) refuse(path, "it is a folder");
    if (fs::exists(status) && !may_write(path)) refuse(path, std::strerror(errno));
    if (fs::exists(status) && !fs::is_regular_file(status)) return {path, true};
    fs::path target = fs::exists(status) ? fs::canonical(path, error) : path;
    if (error && fs::exists(status)) refuse(path, error.message());
    const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
    if (!fs::is_directory(folder, error)) refuse(path, fmt::format("there is no folder '{}'", folder.string()));
    return {target, false};
}

} // namespace

OutputFile::OutputFile(const fs::path& path) : path_(path)
{
    if (path == "-") {
        file_ = stdout;
        return;
    }
    auto [target, in_place] = resolve(path);
    target_ = target;
    if (in_place) {
        file_ = open(target, write_only);
        if (!file_) fail(errno);
        return;
    }
    // A random number keeps two runs that write the same file apart; "x" never follows a link that waits there.
    temporary_ = target.parent_path() / fmt::format(".{}.{}.part", target.filename().string(), std::random_device{}());
    file_ = open(temporary_, create);
    if (!file_) {
        const int error = errno;
        temporary_.clear();
        fail(error);
    }
}

OutputFile::~OutputFile()
{
    if (file_ && file_ != stdout) std::fclose(file_);
    if (!temporary_.empty()) std::remove(temporary_.string().c_str());
}

void OutputFile::flush()
{
    const std::size_t written = std::fwrite(buffer_.data(), 1, buffer_.size(), file_);
    if (written != buffer_.size()) fail(errno);
    buffer_.clear();
}

void OutputFile::commit()
{
    flush();
    if (std::fflush(file_) != 0) fail(errno);
    if (file_ == stdout) return;
    // Some file systems report a full disk or quota only here.
    if (std::fclose(std::exchange(file_, nullptr)) != 0) fail(errno);
    if (temporary_.empty()) return;
    if (std::rename(temporary_.string().c_str(), target_.string().c_str()) != 0) fail(errno);
    temporary_.clear();
}

void OutputFile::fail(int error) const
{
    refuse(path_ == "-" ? fs::path("standard output") : path_, std::strerror(error));
}

void check_writable(const fs::path& path)
{
    // Pipes must not be opened to try: their reader would see an end of file.
    if (path == "-" || resolve(path).in_place) return;
    OutputFile try_it(path);
}

} // namespace oncollide
