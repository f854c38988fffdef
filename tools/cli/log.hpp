#pragma once
#include <string>
#include <string_view>
#include <vector>

// What the program says on standard error beside its results, line by line: "oncollide: warning: ...".
namespace oncollide::tools {

enum class LogLevel { error, warning, note, info, debug };

/// How much is said, from the environment variable ONCOLLIDE_LOG: error, warning, note (the default), info or debug.
/// Throws Error{usage} for another value.
void set_log_level();

/// Whether what has this level is said: to be asked first where a text is expensive.
bool logged(LogLevel level);
/// Says `text`, in one line, whatever is in it; errors always. Info and debug come with the time since the program
/// began. From any thread.
void log(LogLevel level, std::string_view text);
/// What reading put right: the first ten, and how many more there are.
void log_warnings(const std::vector<std::string>& warnings);

/// For texts on a terminal that shows colours (NO_COLOR is not set, TERM is not "dumb"): `text` in red, yellow or
/// green. Unchanged otherwise.
enum class Tint { red, yellow, green };
std::string tinted(Tint tint, std::string_view text, bool on_terminal);

} // namespace oncollide::tools
