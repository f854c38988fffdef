#pragma once
#include "cli/command.hpp"

namespace oncollide::tools {

/// Adds `oncollide accuracy hard`.
CLI::App* add_accuracy_hard(CLI::App& accuracy, Command& command);

} // namespace oncollide::tools
