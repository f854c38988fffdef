// The command of `./dev demo`, which builds in a third of the time of the whole program.
#include "cli/command.hpp"

namespace oncollide::tools {

const Program program{.name = "oncollide",
                      .summary = "The demo of oncollide.",
                      .footer = "All commands are in the program oncollide: './dev build' makes it.",
                      .add_commands = add_demo};

} // namespace oncollide::tools
