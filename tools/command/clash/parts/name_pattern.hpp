#pragma once
#include <string_view>

namespace oncollide::tools {

/// True if `name` matches the pattern: `*` matches any text, `?` one byte, and a backslash makes the next character
/// literal.
bool matches(std::string_view pattern, std::string_view name);

} // namespace oncollide::tools
