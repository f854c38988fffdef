// The commands of `./dev demo`, for a program that is built in half the time of the whole.
#include "cli/command.hpp"

namespace oncollide::tools {

void add_commands(Arguments app)
{
    add_demo(app);
    add_run(app);
    add_check(app);
    add_scene(app);
    add_doctor(app);
}

} // namespace oncollide::tools
