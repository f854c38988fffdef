#pragma once
#include <string>
#include <string_view>
#include <vector>

// Messages on standard error: "oncollide: warning: ...".
namespace oncollide::tools {

/// The name before messages: "oncollide", unless main() sets another one, whose text must stay valid.
void set_program_name(const char* name);
std::string_view program_name();

enum class LogLevel { error, warning, note, info, debug };

/// Sets the log level from the environment variable ONCOLLIDE_LOG: error, warning, note (the default), info or debug.
/// Throws Error{usage} for another value.
void set_log_level();

/// Writes `text` as it is to standard error, in one call, so that texts of several threads and processes do not mix. If
/// standard error cannot be written, such as a log on a full disk, the program does not fail.
void write_to_stderr(std::string_view text);

/// Clears the line of a terminal, which may show progress.
constexpr std::string_view clear_line = "\r\033[K";

/// True if messages of this level are printed. Check it first where building a text is expensive.
bool logged(LogLevel level);
/// Prints `text` on one line, with control characters escaped; errors always. Info and debug lines begin with the time
/// since the program started. Callable from any thread.
void log(LogLevel level, std::string_view text);
/// Prints the first ten warnings of reading a file, and the number of further ones.
void log_warnings(const std::vector<std::string>& warnings);

/// `text` in red, yellow or green if it goes to a terminal that shows colours (NO_COLOR is not set, TERM is not
/// "dumb"); unchanged otherwise.
enum class Tint { red, yellow, green };
std::string tinted(Tint tint, std::string_view text, bool on_terminal);

} // namespace oncollide::tools
