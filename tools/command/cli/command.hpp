#pragma once
#include "cli/arguments.hpp"

namespace oncollide::tools {

/// The program that main() runs. Each executable defines its own Program.
struct Program {
    const char *name, *summary; ///< "oncollide", and what it is for
    const char* footer;         ///< text at the end of --help
    void (*add_commands)(Arguments app);
};
extern const Program program;

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
void add_accuracy(Arguments app);
/// @param peers  a line about other libraries; null: none
void add_doctor(Arguments app, std::string (*peers)() = nullptr);
void add_reference(Arguments app); ///< hidden: for build scripts

// Commands of `oncollide accuracy`.
void add_accuracy_continuous(Arguments accuracy);
void add_accuracy_study(Arguments accuracy);

} // namespace oncollide::tools
