#pragma once
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>

#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/base/reading_progress.hpp>

namespace oncollide {

/// Reads a whole file; "-" is standard input. Throws Error{no_input} if the path is missing, unreadable or not a
/// regular file (folders, pipes, sockets and devices are never opened, as that could block), Error{bad_data} if the
/// file is empty or larger than `most` bytes.
std::string read_file(const std::filesystem::path& path, std::uintmax_t most);

/// The content of a file that may be large, in memory that is not initialised before the file is read into it.
class FileBytes {
public:
    explicit FileBytes(std::size_t size) : bytes_(LargeAllocator<char>().allocate(size)), size_(size) {}
    ~FileBytes() { LargeAllocator<char>().deallocate(bytes_, size_); }
    FileBytes(FileBytes&& other) noexcept
        : bytes_(std::exchange(other.bytes_, nullptr)), size_(std::exchange(other.size_, 0))
    {
    }

    char* data() { return bytes_; }
    std::size_t size() const { return size_; }
    operator std::string_view() const { return {bytes_, size_}; }

private:
    char* bytes_;
    std::size_t size_;
};
FileBytes read_large_file(const std::filesystem::path& path, std::uintmax_t most);

/// Reads a file piece by piece. Never standard input. Throws like read_file().
class FileReader {
public:
    FileReader(const std::filesystem::path& path, std::uintmax_t most);
    std::uintmax_t size() const { return size_; }
    /// Reads the next `size` bytes. Throws Error{no_input} if fewer are left.
    void read(char* bytes, std::size_t size);

private:
    std::filesystem::path path_;
    std::uintmax_t size_ = 0, read_ = 0;
    std::ifstream in_;
    ReadingProgress progress_;
};

/// Throws read_file()'s Error{no_input} without reading the file.
void check_readable(const std::filesystem::path& path);

/// Calls `visit` with the path of each file before it is read; null: no call. Lets a program avoid overwriting its own
/// input. Call only while no file is being read. An exception from `visit` aborts the reading.
void on_file_read(void (*visit)(const std::filesystem::path&));

/// The file name's extension in lower case, such as ".obj"; empty if there is none.
std::string lower_extension(const std::filesystem::path& path);

/// `text` without a leading UTF-8 byte-order mark.
std::string_view without_byte_order_mark(std::string_view text);

} // namespace oncollide
