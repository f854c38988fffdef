#pragma once
#include "cli/command.hpp"

namespace oncollide::tools {

/// Adds `oncollide accuracy study`.
CLI::App* add_accuracy_study(CLI::App& accuracy, Command& command);

} // namespace oncollide::tools
