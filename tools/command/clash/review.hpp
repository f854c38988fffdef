#pragma once
#include "cli/arguments.hpp"

namespace oncollide::tools {

/// Adds `clash review`: statuses and comments of the clashes in a JSON report.
void add_clash_review(Arguments clash);

} // namespace oncollide::tools
