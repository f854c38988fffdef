#pragma once
#include "cli/arguments.hpp"

namespace oncollide::tools {

// Each function adds one command of oncollide-lab.
void add_bench(Arguments app);
void add_hard(Arguments app);
void add_fuzz(Arguments app);
void add_league(Arguments app);
void add_manifolds(Arguments app);

} // namespace oncollide::tools
