#pragma once
#include <string_view>

// Standard output. All text of all commands is printed here, so that no command succeeds if its text is lost.
namespace oncollide::tools {

/// Prints `text` as it is.
/// @param taken  results have standard output to themselves ("-"): print to standard error
void write_to_stdout(std::string_view text, bool taken = false);

/// Hands what was printed to its reader: before a long computation, or before results that take longer to write.
void flush_stdout();

/// Throws Error{cannot_write} if anything that was printed could not be written, because standard output is closed, its
/// disk is full, and so on.
void check_stdout();

} // namespace oncollide::tools
