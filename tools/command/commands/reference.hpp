#pragma once
#include <string>

#include "cli/arguments.hpp"

// References generated from the options, so that they are always up to date.
namespace oncollide::tools {

std::string markdown_of(const CommandText& program); ///< one page, for docs/
std::string settings_markdown();                     ///< a table of all settings, for docs/choosing.md
std::string man_page_of(const CommandText& command, const CommandText& program);

/// Completion of the program's commands, options and their values. `scenes`: the values for NAME.
std::string bash_completion_of(const CommandText& program, const std::vector<std::string>& scenes);
std::string zsh_completion_of(const CommandText& program, const std::vector<std::string>& scenes);
std::string fish_completion_of(const CommandText& program, const std::vector<std::string>& scenes);

} // namespace oncollide::tools
