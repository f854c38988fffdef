#pragma once
#include <string>
#include <string_view>

namespace oncollide {

/// `text` made safe for a terminal. Control characters (escape sequences, line ends, C1 controls), marks that change
/// the writing direction, and line and paragraph separators become escapes such as \x1b or \u202e; bytes that are not
/// UTF-8 become \xff and the like. All other characters stay, including backslashes.
std::string printable(std::string_view text);

/// The same, but line ends stay.
std::string printable_lines(std::string_view text);

} // namespace oncollide
