#include <oncollide/base/files/file_bytes.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/system_file.hpp>

namespace oncollide {

namespace {

namespace fs = std::filesystem;

void (*read_visitor)(const fs::path&) = nullptr;

[[noreturn]] void fail(const fs::path& path, ErrorKind kind, const std::string& what)
{
    throw Error(kind, fmt::format("{}: {}", path == "-" ? "standard input" : path.string(), what));
}

[[noreturn]] void fail_size(const fs::path& path, std::uintmax_t size, std::uintmax_t most)
{
    fail(path, ErrorKind::bad_data, fmt::format("the file has {} bytes; at most {} are allowed", size, most));
}

[[noreturn]] void fail_empty(const fs::path& path)
{
    fail(path, ErrorKind::bad_data, "the file is empty");
}

const char* name_of(fs::file_type type)
{
    switch (type) {
    case fs::file_type::fifo:
        return "it is a pipe";
    case fs::file_type::socket:
        return "it is a socket";
    case fs::file_type::block:
    case fs::file_type::character:
        return "it is a device";
    default:
        return "its kind is unknown";
    }
}

std::string read_standard_input(std::uintmax_t most)
{
    std::string bytes;
    std::array<char, 1 << 16> piece;
    while (const std::size_t size = std::fread(piece.data(), 1, piece.size(), stdin)) {
        bytes.append(piece.data(), size);
        if (bytes.size() > most) fail_size("-", bytes.size(), most);
    }
    if (std::ferror(stdin)) fail("-", ErrorKind::no_input, "cannot be read");
    if (bytes.empty()) fail_empty("-");
    return bytes;
}

/// Opens a file for reading as a whole, and returns its size in `size`.
std::ifstream open_file(const fs::path& path, std::uintmax_t most, std::uintmax_t& size)
{
    check_readable(path);
    std::error_code error;
    size = fs::file_size(path, error);
    std::ifstream in(path, std::ios::binary);
    if (error || !in) fail(path, ErrorKind::no_input, "cannot be read; check its permissions");
    if (size > most) fail_size(path, size, most);
    if (size == 0) fail_empty(path);
    return in;
}

} // namespace

std::string read_file(const fs::path& path, std::uintmax_t most)
{
    if (path == "-") return read_standard_input(most);
    FileReader file(path, most);
    std::string bytes(file.size(), '\0');
    file.read(bytes.data(), bytes.size());
    return bytes;
}

FileBytes read_large_file(const fs::path& path, std::uintmax_t most)
{
    if (path == "-") {
        const std::string input = read_standard_input(most);
        FileBytes bytes(input.size());
        input.copy(bytes.data(), input.size());
        return bytes;
    }
    FileReader file(path, most);
    FileBytes bytes(file.size());
    file.read(bytes.data(), bytes.size());
    return bytes;
}

FileReader::FileReader(const fs::path& path, std::uintmax_t most)
    : path_(path), in_(open_file(path, most, size_)), progress_(path.string(), size_)
{
}

void FileReader::read(char* bytes, std::size_t size)
{
    constexpr std::size_t piece = std::size_t{16} << 20;
    while (size > 0) {
        const std::size_t length = std::min(piece, size);
        in_.read(bytes, static_cast<std::streamsize>(length));
        if (static_cast<std::size_t>(in_.gcount()) != length)
            fail(path_, ErrorKind::no_input, "cannot be read to its end");
        bytes += length, size -= length;
        progress_.at(read_ += length);
    }
}

void check_readable(const fs::path& path)
{
    const auto refuse_it = [&](const std::string& what) { fail(path, ErrorKind::no_input, what); };
    if (path.native().find(fs::path::value_type{}) != path.native().npos) refuse_it("a name cannot hold a zero byte");
    if (is_reserved_for_device(path)) refuse_it("is not a readable file: it is a device");
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (status.type() == fs::file_type::not_found)
        refuse_it(is_address(path.string()) ? "is an address; files are read from this machine only: save a copy of it"
                                            : "no such file");
    if (status.type() == fs::file_type::none) refuse_it(fmt::format("cannot be read: {}", error.message()));
    if (fs::is_directory(status)) refuse_it("is a folder, not a file");
    if (!fs::is_regular_file(status)) refuse_it(fmt::format("is not a readable file: {}", name_of(status.type())));
    if (read_visitor) read_visitor(path);
}

void on_file_read(void (*visit)(const fs::path&))
{
    read_visitor = visit;
}

std::string lower_extension(const fs::path& path)
{
    std::string extension = path.extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

std::string_view without_byte_order_mark(std::string_view text)
{
    constexpr std::string_view mark = "\xef\xbb\xbf";
    return text.starts_with(mark) ? text.substr(mark.size()) : text;
}

} // namespace oncollide
