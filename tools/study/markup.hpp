#pragma once
#include <string>
#include <string_view>

namespace oncollide::tools {

/// `text` for SVG and HTML, between tags or in a quoted attribute. Control characters, which XML has none of, become
/// spaces.
std::string escaped(std::string_view text);

/// `bytes` as base64 (RFC 4648), for data: URIs.
std::string base64(std::string_view bytes);

} // namespace oncollide::tools
