// The command of `./dev demo`: this program builds in a third of the time of the whole.
#include "cli/command.hpp"

namespace oncollide::tools {

void add_commands(Arguments app)
{
    add_demo(app);
}

} // namespace oncollide::tools
