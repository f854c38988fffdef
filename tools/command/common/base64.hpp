#pragma once
#include <string>
#include <string_view>

namespace oncollide::tools {

/// `bytes` as base64 (RFC 4648), for data: URIs.
std::string base64(std::string_view bytes);

} // namespace oncollide::tools
