#pragma once
#include <cstdint>
#include <filesystem>
#include <string_view>

namespace oncollide {

/// A file to which several processes write disjoint parts, named FILE.part until rename() makes it FILE.
/// Errors are Error{cannot_write} and name the file.
class SharedFile {
public:
    explicit SharedFile(std::filesystem::path path) : path_(std::move(path)) {}
    ~SharedFile();
    SharedFile(const SharedFile&) = delete;

    /// If FILE.part does not exist and FILE does, is newer than `than` and has at least `size` bytes: copies FILE to
    /// FILE.part.
    void take_back(std::uint64_t size, const std::filesystem::path& than) const;
    /// create(): called by one process first; keeps an existing file. open(): called by all.
    void create();
    void open();
    void write(std::uint64_t offset, std::string_view bytes);
    void truncate(std::uint64_t size);
    std::uint64_t size() const;
    /// Returns once this process's writes are on disk.
    void sync();
    /// Called by one process, after all have called sync().
    void rename();
    /// Called by one process: deletes FILE.part.
    void remove() noexcept;

private:
    std::filesystem::path part() const { return std::filesystem::path(path_).concat(".part"); }
    [[noreturn]] void fail(int error) const;

    std::filesystem::path path_;
    std::intptr_t file_ = -1; ///< a file descriptor, or a HANDLE of Windows (windows/shared_file.cpp)
};

} // namespace oncollide
