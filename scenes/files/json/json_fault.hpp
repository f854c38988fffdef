#pragma once
#include <string>
#include <string_view>

namespace oncollide {

/// Throws Error{bad_data} that says what JSON reading (json_tape.hpp) found wrong with `text`, the message beginning
/// with `file`: syntax errors with line and column, numbers too large for a double, a key given twice in one object,
/// more than 32 levels of nesting. Reads the whole text again, slowly. Private to scenes.
/// @param where  where reading stopped, for what this does not find
[[noreturn]] void explain_json(const std::string& file, std::string_view text, const char* where);

} // namespace oncollide
