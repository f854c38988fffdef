#pragma once
#include <cstdint>
#include <filesystem>
#include <string_view>

namespace oncollide {

/// A file that several processes write, each its own part: under the name FILE.part, until rename() makes it FILE.
/// Errors are Error{cannot_write}, and name the file.
class SharedFile {
public:
    explicit SharedFile(std::filesystem::path path) : path_(std::move(path)) {}
    ~SharedFile();
    SharedFile(const SharedFile&) = delete;

    /// Where FILE is there, newer than `than` and at least `size` bytes long, and FILE.part is not: begins with a copy
    /// of FILE.
    void take_back(std::uint64_t size, const std::filesystem::path& than) const;
    /// Opens it, once one process has created it; what was there stays.
    void create();
    void open();
    void write(std::uint64_t offset, std::string_view bytes);
    void truncate(std::uint64_t size);
    std::uint64_t size() const;
    /// Until what this process wrote is on the disk.
    void sync();
    /// By one process, once all have called sync().
    void rename();
    /// By one process: gives it up.
    void remove() noexcept;

private:
    std::filesystem::path part() const { return path_.string() + ".part"; }
    [[noreturn]] void fail(int error) const;

    std::filesystem::path path_;
    int file_ = -1;
};

} // namespace oncollide
