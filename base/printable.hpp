#pragma once
#include <string>
#include <string_view>

namespace oncollide {

/// `text` as it may go to a terminal: control characters (escape sequences, line ends, those of Unicode's C1), marks
/// that turn the direction of writing, and line and paragraph separators become \x1b or \u202e; bytes that are not
/// UTF-8 become \xff. All else stays, backslashes too.
std::string printable(std::string_view text);

/// The same for a text of several lines, which stay.
std::string printable_lines(std::string_view text);

} // namespace oncollide
