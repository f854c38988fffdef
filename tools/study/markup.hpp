#pragma once
#include <string>
#include <string_view>

#include <oncollide/base/output_file.hpp>

namespace oncollide::tools {

/// `text` for SVG and HTML, between tags or in a quoted attribute. Control characters, which XML does not allow, become
/// spaces.
std::string escaped(std::string_view text);

/// Writes SVG text. @param anchor  start, middle or end  @param style  a class of the style sheet
void svg_text(OutputFile& file, double x, double y, std::string_view anchor, std::string_view style,
              std::string_view words);

/// `bytes` as base64 (RFC 4648), for data: URIs.
std::string base64(std::string_view bytes);

} // namespace oncollide::tools
