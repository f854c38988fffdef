#pragma once
#include "cli/arguments.hpp"

namespace oncollide::tools {

/// Adds the commands of this program. Each executable defines its own list.
void add_commands(Arguments app);

// Each function adds one command.
void add_demo(Arguments app);
void add_run(Arguments app);
void add_view(Arguments app);
void add_merge(Arguments app);
void add_render(Arguments app);
void add_check(Arguments app);
void add_clash(Arguments app);
void add_cook(Arguments app);
void add_robot(Arguments app);
void add_scene(Arguments app);
void add_spheres(Arguments app);
void add_bench(Arguments app);
void add_accuracy(Arguments app);
void add_doctor(Arguments app);
void add_reference(Arguments app); ///< hidden: for build scripts

// Commands of `oncollide accuracy`.
void add_accuracy_continuous(Arguments accuracy);
void add_accuracy_fuzz(Arguments accuracy);
void add_accuracy_hard(Arguments accuracy);
void add_accuracy_manifolds(Arguments accuracy);
void add_accuracy_study(Arguments accuracy);

} // namespace oncollide::tools
