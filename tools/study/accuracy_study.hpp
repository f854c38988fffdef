#pragma once
#include "cli/command.hpp"

namespace oncollide::tools {

/// Adds `oncollide accuracy study`.
void add_accuracy_study(Arguments accuracy);

} // namespace oncollide::tools
