#pragma once
#include <string>
#include <string_view>

namespace oncollide {

/// Throws Error{bad_data} with the fault that JSON reading (json_tape.hpp) found in `text`, prefixed with `file`:
/// syntax errors with line and column, numbers too large for a double, a duplicate key in an object, more than 32
/// levels of nesting. Slow: reads the whole text again. Private to scenes.
/// @param where  where reading stopped, for faults that this second reading does not find
[[noreturn]] void explain_json(const std::string& file, std::string_view text, const char* where);

} // namespace oncollide
