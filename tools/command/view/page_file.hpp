#pragma once
#include <string_view>

#include <nlohmann/json.hpp>

#include <oncollide/base/files/output_file.hpp>

#include "view/page_blocks.hpp"

namespace oncollide::tools {

/// Writes a page from a template with marks such as {{title}}.
class PageFile {
public:
    PageFile(OutputFile& file, std::string_view html) : file_(file), rest_(html) {}
    /// Writes the template up to the mark, which it leaves out.
    void until(std::string_view mark);
    void write(std::string_view text) { file_.write(text); }
    /// Writes a script element with JSON. Nothing in it ends the element or begins a comment; bytes that are not UTF-8
    /// become U+FFFD.
    void add_json(std::string_view id, const nlohmann::json& value);
    /// Writes a script element with binary columns in base64.
    /// @param encoded  in base64
    void add_block(std::string_view id, std::string_view encoded);
    void finish() { file_.write(rest_); }

private:
    OutputFile& file_;
    std::string_view rest_;
};

/// The JSON that PageFile::add_json() writes.
std::string script_json(const nlohmann::json& value);
/// "3.1 MB"
std::string megabytes(std::size_t bytes);
/// Size of binary columns in base64.
constexpr std::size_t encoded_size(std::size_t bytes)
{
    return (bytes + 2) / 3 * 4;
}

} // namespace oncollide::tools
