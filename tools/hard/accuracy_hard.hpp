#pragma once
#include "cli/command.hpp"

namespace oncollide::tools {

/// Adds `oncollide accuracy hard`.
void add_accuracy_hard(Arguments accuracy);

} // namespace oncollide::tools
