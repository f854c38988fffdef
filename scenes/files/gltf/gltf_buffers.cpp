#include <oncollide/scenes/files/gltf/gltf_buffers.hpp>

#include <filesystem>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>

namespace oncollide {

namespace {

constexpr std::uint64_t most_buffer_bytes = std::uint64_t(2) << 30; ///< most bytes of all files of buffers together

int sextet(char c)
{
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

std::string decode_base64(const Node& uri, std::string_view text)
{
    for (int padding = 0; padding < 2 && text.ends_with('='); ++padding) text.remove_suffix(1);
    if (text.size() % 4 == 1) uri.fail("its base64 data end within a byte");
    std::string bytes;
    bytes.reserve(text.size() / 4 * 3 + 2);
    std::uint32_t bits = 0;
    int held = 0;
    for (const char c : text) {
        const int value = sextet(c);
        if (value < 0) uri.fail(fmt::format("{} is no digit of base64", oncollide::quoted({&c, 1})));
        bits = bits << 6 | static_cast<std::uint32_t>(value);
        if ((held += 6) >= 8) bytes += static_cast<char>(bits >> (held -= 8));
    }
    return bytes;
}

int hex_digit(char c)
{
    if (c >= '0' && c <= '9') return c - '0';
    const char lower = static_cast<char>(c | 0x20);
    return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

/// Replaces escapes such as `%20` by their characters.
std::string decode_percent(const Node& uri, std::string_view text)
{
    std::string name;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            name += text[i];
            continue;
        }
        const int high = i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
        const int low = i + 2 < text.size() ? hex_digit(text[i + 2]) : -1;
        if (high < 0 || low < 0) uri.fail("has a '%' without two hexadecimal digits after it");
        name += static_cast<char>(high << 4 | low);
        i += 2;
    }
    return name;
}

} // namespace

GltfBuffers::GltfBuffers(const GltfDocument& document)
    : document_(document), buffers_(document.all(GltfDocument::buffers).size())
{
}

std::string_view GltfBuffers::view(const Node& number)
{
    const Node& view = document_.at(GltfDocument::buffer_views, number);
    const std::string_view bytes = buffer(view["buffer"]);
    const std::uint64_t offset = view.has("byteOffset") ? view["byteOffset"].natural() : 0;
    const std::uint64_t length = view["byteLength"].natural();
    if (offset > bytes.size() || length > bytes.size() - offset)
        view.fail(fmt::format("takes {} bytes from byte {} on, but the buffer has {}", length, offset, bytes.size()));
    return bytes.substr(offset, length);
}

std::string_view GltfBuffers::buffer(const Node& number)
{
    const std::size_t index = document_.index(GltfDocument::buffers, number);
    if (!buffers_[index]) buffers_[index] = load(index);
    return *buffers_[index];
}

std::string_view GltfBuffers::load(std::size_t number)
{
    const Node& buffer = document_.all(GltfDocument::buffers)[number];
    const std::uint64_t length = buffer["byteLength"].natural();
    std::string_view bytes;
    std::string where = "the buffer";
    if (!buffer.has("uri")) {
        if (number != 0 || document_.binary_chunk().empty())
            buffer.fail("has no 'uri', and the file has no binary chunk for it");
        bytes = document_.binary_chunk();
        where = "the binary chunk";
    } else if (const Node uri = buffer["uri"]; uri.text().starts_with("data:")) {
        const std::string_view text = uri.text();
        const std::size_t comma = text.find(',');
        if (comma == text.npos || !text.substr(0, comma).ends_with(";base64"))
            uri.fail("data in the file itself must be 'data:...;base64,...'");
        bytes = decoded_.emplace_back(decode_base64(uri, text.substr(comma + 1)));
    } else {
        bytes = beside(uri);
        where = fmt::format("the file of its buffer, {},", oncollide::quoted(uri.text()));
    }
    if (bytes.size() < length)
        document_.source().fail(fmt::format("truncated: {} has {} of {} bytes", where, bytes.size(), length));
    return bytes.substr(0, length);
}

const std::string& GltfBuffers::beside(const Node& uri)
{
    const std::string name = decode_percent(uri, uri.text());
    if (const auto found = files_.find(name); found != files_.end()) return found->second;
    const std::filesystem::path folder = path_of(document_.source().name).parent_path();
    try {
        const std::string& bytes = files_[name] = read_file(file_in(folder, name), most_buffer_bytes - bytes_read_);
        bytes_read_ += bytes.size();
        return bytes;
    } catch (const Error& error) { // of any kind: the file that was requested exists, but is incomplete
        document_.source().fail(fmt::format("the file of a buffer cannot be read: {}", error.what()));
    }
}

} // namespace oncollide
