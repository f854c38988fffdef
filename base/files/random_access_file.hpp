#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace oncollide {

/// A file open for reading at any place. Other programs may change, rename or delete it meanwhile: it is never mapped,
/// because truncating a mapped file ends the program, and checked data could change afterwards. Const calls are safe
/// from many threads at once. Private to the library; Windows: windows/random_access_file.cpp.
class RandomAccessFile {
public:
    RandomAccessFile() = default;
    explicit RandomAccessFile(const std::filesystem::path& path);
    ~RandomAccessFile() { close(); }
    RandomAccessFile(const RandomAccessFile&) = delete;
    RandomAccessFile& operator=(const RandomAccessFile&) = delete;

    bool is_open() const { return file_ != none; }
    void close();
    /// Bytes; -1: unavailable.
    std::int64_t size() const;
    /// Fills `out`. Returns why that failed; null: success.
    const char* read(std::uint64_t offset, std::span<std::byte> out) const;

private:
    static constexpr std::intptr_t none = -1;
    std::intptr_t file_ = none; ///< a file descriptor, or a HANDLE
};

} // namespace oncollide
