// The commands of oncollide.
#include "cli/command.hpp"
#include "convert/converters.hpp"

namespace oncollide::tools {

const Program program{
    .name = "oncollide",
    .summary = "Finds which bodies of a large environment collide, frame by frame, at a certified accuracy.",
    .footer =
        "Exit codes: 0 success, 64 usage, 65 bad data, 66 no input, 70 internal fault, 71 no GPU, 73 cannot write,\n"
        "130 interrupted. 'check' returns 0 separate, 1 colliding, 2 within or undecided; so does 'run --exit-code'.\n"
        "Environment: ONCOLLIDE_LOG=info or debug prints more to standard error, NO_COLOR=1 turns off colours.\n"
        "Start with 'oncollide demo', then 'oncollide COMMAND --help'.",
    .add_commands = [](Arguments app) {
        read_converted_files();
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
        add_accuracy(app);
        add_doctor(app);
        add_reference(app);
        app.refuse_command("bench", "benchmarks are commands of another program: oncollide-lab bench");
    }};

} // namespace oncollide::tools
