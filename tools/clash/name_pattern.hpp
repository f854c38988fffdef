#pragma once
#include <string_view>

namespace oncollide::tools {

/// Is `name` as the pattern says? `*` stands for any text, `?` for one byte; a backslash takes away what the next
/// character would mean.
bool matches(std::string_view pattern, std::string_view name);

} // namespace oncollide::tools
