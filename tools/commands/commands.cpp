// The commands of the installed program.
#include "cli/command.hpp"

namespace oncollide::tools {

void add_commands(Arguments app)
{
    add_demo(app);
    add_run(app);
    add_view(app);
    add_merge(app);
    add_render(app);
    add_check(app);
    add_clash(app);
    add_cook(app);
    add_robot(app);
    add_scene(app);
    add_spheres(app);
    add_bench(app);
    add_accuracy(app);
    add_doctor(app);
    add_reference(app);
}

} // namespace oncollide::tools
