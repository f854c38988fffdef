#pragma once
#include <functional>

#include <CLI/CLI.hpp>

namespace oncollide::tools {

/// What the chosen subcommand does; returns the exit code. Parsing only chooses it, so that a bad command line is told
/// from work that fails.
using Command = std::function<int()>;

// Each adds one subcommand to `app`; when the command line picks it, `command` becomes its action.
void add_demo(CLI::App& app, Command& command);
void add_run(CLI::App& app, Command& command);
void add_render(CLI::App& app, Command& command);
void add_check(CLI::App& app, Command& command);
void add_scene(CLI::App& app, Command& command);
void add_spheres(CLI::App& app, Command& command);
void add_bench(CLI::App& app, Command& command);
void add_accuracy(CLI::App& app, Command& command);
void add_doctor(CLI::App& app, Command& command);

} // namespace oncollide::tools
