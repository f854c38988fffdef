#include "cli/log.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/text/printable.hpp>

#include "cli/system.hpp"

namespace oncollide::tools {
namespace {

constexpr std::array<std::string_view, 5> level_names{"error", "warning", "note", "info", "debug"};

const std::chrono::steady_clock::time_point program_begin = std::chrono::steady_clock::now();
LogLevel level_said = LogLevel::note;
const char* name_said = "oncollide";

bool shows_colours()
{
    const char *no = std::getenv("NO_COLOR"), *terminal = std::getenv("TERM");
    return !(no && *no) && !(terminal && std::string_view(terminal) == "dumb");
}

} // namespace

void set_program_name(const char* name)
{
    name_said = name;
}

std::string_view program_name()
{
    return name_said;
}

void set_log_level()
{
    const char* const variable = std::getenv("ONCOLLIDE_LOG");
    if (!variable || !*variable) return;
    for (std::size_t k = 0; k < level_names.size(); ++k)
        if (level_names[k] == variable) {
            level_said = LogLevel(k);
            return;
        }
    throw Error(ErrorKind::usage, fmt::format("ONCOLLIDE_LOG: unknown level '{}'{}", variable,
                                              valid_names(variable, {level_names.begin(), level_names.end()})));
}

void write_to_stderr(std::string_view text)
{
    [[maybe_unused]] const std::size_t written = std::fwrite(text.data(), 1, text.size(), stderr);
}

bool logged(LogLevel level)
{
    return level <= level_said;
}

void log(LogLevel level, std::string_view text)
{
    if (!logged(level)) return;
    const bool terminal = stderr_is_terminal();
    std::string label = fmt::format("{}:", name_said);
    if (level == LogLevel::error) label = tinted(Tint::red, label, terminal);
    if (level == LogLevel::warning) label += " " + tinted(Tint::yellow, "warning:", terminal);
    if (level == LogLevel::note) label += " note:";
    if (level > LogLevel::note)
        label += fmt::format(" {}: {:.3f} s:", level_names[std::size_t(level)],
                             std::chrono::duration<double>(std::chrono::steady_clock::now() - program_begin).count());
    write_to_stderr(
        fmt::format("{}{} {}\n", terminal ? clear_line : "", label, shortened(printable(text), most_of_a_message)));
}

void log_warnings(const std::vector<std::string>& warnings)
{
    constexpr std::size_t most = 10;
    for (std::size_t k = 0; k < std::min(warnings.size(), most); ++k) log(LogLevel::warning, warnings[k]);
    if (warnings.size() > most) log(LogLevel::warning, fmt::format("and {} more warnings", warnings.size() - most));
}

std::string tinted(Tint tint, std::string_view text, bool on_terminal)
{
    if (!on_terminal || !shows_colours()) return std::string(text);
    constexpr int codes[] = {31, 33, 32};
    return fmt::format("\033[{}m{}\033[0m", codes[int(tint)], text);
}

} // namespace oncollide::tools
