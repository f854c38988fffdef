#pragma once
#include <cstdio>
#include <filesystem>

#include <oncollide/base/text_sink.hpp>

namespace oncollide {

/// A file that appears complete or not at all: it is written under a temporary name in the folder of `path`, and
/// commit() renames it. "-" is standard output. Devices and pipes are written in place. If the path is a symbolic link,
/// its target is replaced. A replaced file keeps its permissions and, if the system allows it, its owner.
class OutputFile final : public TextSink {
public:
    /// Throws Error{cannot_write}.
    explicit OutputFile(const std::filesystem::path& path);
    /// Removes the temporary file unless committed.
    ~OutputFile();
    /// Flushes, closes and renames. Throws Error{cannot_write}, for instance if the disk is full.
    void commit();

private:
    void create_temporary();
    void flush() override;
    [[noreturn]] void fail(int error) const;

    std::filesystem::path path_;      ///< as the caller named it, for errors
    std::filesystem::path target_;    ///< links resolved
    std::filesystem::path temporary_; ///< empty if written in place
    int slot_ = -1;                   ///< position in the list of unfinished files
    std::FILE* file_ = nullptr;
};

/// Removes the temporary files of all OutputFiles. Safe in signal handlers, and meant only for signals that end the
/// program: any later output is lost.
void remove_unfinished_files() noexcept;

/// Throws Error{cannot_write} with the reason if `path` cannot be written now; leaves no file behind. Call it before
/// long work. "-" is standard output.
void check_writable(const std::filesystem::path& path);

} // namespace oncollide
