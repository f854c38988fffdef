#pragma once
#include <string_view>

// Standard output. All text of all commands is printed here, so that no command succeeds if its text is lost.
namespace oncollide::tools {

/// Prints `text` as it is.
/// @param taken  results use standard output ("-"), so print to standard error
void write_to_stdout(std::string_view text, bool taken = false);

/// Hands the text printed so far to its reader. Call it before a long computation.
void flush_stdout();

/// Throws Error{cannot_write} if any text printed so far could not be written, for instance because standard output is
/// closed or its disk is full.
void check_stdout();

} // namespace oncollide::tools
