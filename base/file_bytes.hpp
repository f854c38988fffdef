#pragma once
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>

#include <oncollide/base/large_vector.hpp>
#include <oncollide/base/reading_progress.hpp>

namespace oncollide {

/// A whole file; "-" is all of standard input. Throws Error{no_input} when it is missing, unreadable or no file (a
/// folder, pipe, socket or device: nothing is opened that could block), Error{bad_data} when it is empty or larger than
/// `most` bytes.
std::string read_file(const std::filesystem::path& path, std::uintmax_t most);

/// The same for files that may be large: memory that nothing fills before the file does.
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

/// The same piece by piece, for what need not be in memory as a whole. Never standard input.
class FileReader {
public:
    FileReader(const std::filesystem::path& path, std::uintmax_t most);
    std::uintmax_t size() const { return size_; }
    /// The next `size` bytes. Throws Error{no_input} where the file has fewer.
    void read(char* bytes, std::size_t size);

private:
    std::filesystem::path path_;
    std::uintmax_t size_ = 0, read_ = 0;
    std::ifstream in_;
    ReadingProgress progress_;
};

/// Throws the Error{no_input} of read_file, for files that are read piece by piece.
void check_readable(const std::filesystem::path& path);

/// Calls `visit` with each file that is about to be read from now on, null: nobody. For a program that must not
/// overwrite what it reads; set while nothing is read. What `visit` throws, if it is no Error, ends the reading.
void on_file_read(void (*visit)(const std::filesystem::path&));

/// The file that another file, in `folder`, calls `name`; never standard input.
std::filesystem::path file_in(const std::filesystem::path& folder, std::string_view name);

/// What the name ends with, by which kinds of files are known, in small letters: ".obj"; empty where it has none.
std::string lower_extension(const std::filesystem::path& path);

/// `text` without the byte-order mark that some editors put before UTF-8.
std::string_view without_byte_order_mark(std::string_view text);

} // namespace oncollide
