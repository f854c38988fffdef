#include <oncollide/base/file_bytes.hpp>

#include <fstream>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

std::string read_file(const std::filesystem::path& path, std::uintmax_t most)
{
    const auto fail = [&](ErrorKind kind, const std::string& what) {
        throw Error(kind, fmt::format("{}: {}", path.string(), what));
    };
    if (path.native().find('\0') != path.native().npos) fail(ErrorKind::no_input, "a name cannot hold a zero byte");
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path, error);
    if (status.type() == std::filesystem::file_type::not_found) fail(ErrorKind::no_input, "no such file");
    if (std::filesystem::is_directory(status)) fail(ErrorKind::no_input, "is a folder, not a file");
    if (!std::filesystem::is_regular_file(status)) fail(ErrorKind::no_input, "is not a readable file");
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    std::ifstream in(path, std::ios::binary);
    if (error || !in) fail(ErrorKind::no_input, "cannot be read; check its permissions");
    if (size == 0) fail(ErrorKind::bad_data, "the file is empty");
    if (size > most)
        fail(ErrorKind::bad_data, fmt::format("the file has {} bytes; at most {} are allowed", size, most));
    std::string bytes(size, '\0');
    in.read(bytes.data(), static_cast<std::streamsize>(size));
    if (in.gcount() != static_cast<std::streamsize>(size)) fail(ErrorKind::no_input, "cannot be read to its end");
    return bytes;
}

std::string_view without_byte_order_mark(std::string_view text)
{
    constexpr std::string_view mark = "\xef\xbb\xbf";
    return text.starts_with(mark) ? text.substr(mark.size()) : text;
}

} // namespace oncollide
