#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/files/system_file.hpp>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <random>
#include <utility>

namespace oncollide {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& path, const std::string& why)
{
    throw Error(ErrorKind::cannot_write, fmt::format("{}: cannot write: {}", path.string(), why));
}

/// Names of temporary files, readable by a signal handler, which cannot lock or allocate. Once all slots are used,
/// further files are not listed, and the handler leaves them behind.
using NativeName = const fs::path::value_type*;
std::array<std::atomic<NativeName>, 64> unfinished{};

int enlist(NativeName name)
{
    for (std::size_t slot = 0; slot < unfinished.size(); ++slot)
        if (NativeName free = nullptr; unfinished[slot].compare_exchange_strong(free, name))
            return static_cast<int>(slot);
    return -1;
}

void discharge(int& slot)
{
    if (slot >= 0) unfinished[static_cast<std::size_t>(std::exchange(slot, -1))] = nullptr;
}

/// `path` with links followed, checked as far as is possible without opening it.
struct Target {
    fs::path path;
    bool in_place; ///< a device or a pipe: a rename would replace it by a regular file
};

Target resolve(const fs::path& path)
{
    if (path.empty()) refuse("(no name)", "the file name is empty");
    if (is_reserved_for_device(path)) return {path, true};
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (status.type() == fs::file_type::none) refuse(path, error.message());
    if (fs::is_directory(status)) refuse(path, "it is a folder");
    if (fs::exists(status) && !may_write(path)) refuse(path, std::strerror(errno));
    if (fs::exists(status) && !fs::is_regular_file(status)) return {path, true};
    fs::path target = path;
    if (fs::exists(status)) {
        target = fs::canonical(path, error);
        if (error) refuse(path, error.message());
    }
    while (fs::is_symlink(target, error)) // dangling links; loops were rejected above
        target = target.parent_path() / fs::read_symlink(target, error);
    const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
    if (!fs::is_directory(folder, error)) refuse(path, fmt::format("there is no folder '{}'", folder.string()));
    return {target, false};
}

} // namespace

OutputFile::OutputFile(const fs::path& path) : TextSink(60'000), path_(path)
{
    if (path == "-") {
        file_ = stdout;
        return;
    }
    auto [target, in_place] = resolve(path);
    target_ = target;
    if (in_place) {
        file_ = open_to_write(target, FileUse::write);
        if (!file_) fail(errno);
        return;
    }
    create_temporary();
    copy_permissions(target, file_);
}

/// The random number avoids the names of other runs, including killed ones. FileUse::create never follows a link
/// planted there.
void OutputFile::create_temporary()
{
    const auto name = target_.filename().native().substr(0, 200); // file systems allow 255 characters
    std::random_device random;
    for (int tries = 0; !file_ && tries < 100; ++tries) {
        temporary_ = target_.parent_path() / ".";
        temporary_ += name, temporary_ += fmt::format(".{:08x}.part", random());
        slot_ = enlist(temporary_.c_str());
        file_ = open_to_write(temporary_, FileUse::create);
        if (file_) return;
        const int error = errno;
        discharge(slot_);
        temporary_.clear();
        if (error != EEXIST) fail(error);
    }
    fail(EEXIST);
}

OutputFile::~OutputFile()
{
    if (file_ && file_ != stdout) std::fclose(file_);
    if (!temporary_.empty()) remove_in_handler(temporary_.c_str());
    discharge(slot_);
}

void remove_unfinished_files() noexcept
{
    for (const std::atomic<NativeName>& name : unfinished)
        if (const NativeName file = name.load()) remove_in_handler(file);
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
    // Some file systems report a full disk or an exceeded quota only here.
    if (std::fclose(std::exchange(file_, nullptr)) != 0) fail(errno);
    if (temporary_.empty()) return;
    if (!replace_file(temporary_, target_)) fail(errno);
    discharge(slot_);
    temporary_.clear();
}

void OutputFile::fail(int error) const
{
    refuse(path_ == "-" ? fs::path("standard output") : path_, std::strerror(error));
}

void check_writable(const fs::path& path)
{
    // Do not open pipes as a test: their reader would see an end of file.
    if (path == "-" || resolve(path).in_place) return;
    OutputFile try_it(path);
}

} // namespace oncollide
