#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace oncollide {

/// A whole file. Private to scenes. Throws Error{no_input} when it is missing, a folder or unreadable, Error{bad_data}
/// when it is empty or larger than `most` bytes.
std::string read_file(const std::filesystem::path& path, std::uintmax_t most);

/// `text` without the byte-order mark that some editors put before UTF-8.
std::string_view without_byte_order_mark(std::string_view text);

} // namespace oncollide
