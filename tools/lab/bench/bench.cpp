// oncollide-lab bench: one subcommand per benchmark.
#include "bench/common/benchmarks.hpp"
#include "commands/lab.hpp"

namespace oncollide::tools {

void add_bench(Arguments app)
{
    Arguments bench =
        app.add_command("bench", "Measure oncollide and other libraries in one run, on the same workload, in "
                                 "alternation");
    bench.at_most_one_command();
    bench.action([]() -> int {
        usage(
            "bench: choose a benchmark: broad, narrow, planner, continuous, rays, edges, contacts, avalanche, robot, "
            "robot-distances, world, environment, distances, self, deform, dig, shapes, clash, read, scale, many, gpu, "
            "poses or scene "
            "(oncollide-lab bench --help)");
    });
    add_broad(bench);
    add_narrow(bench);
    add_planner(bench);
    add_continuous(bench);
    add_rays(bench);
    add_edges_bench(bench);
    add_contacts(bench);
    add_avalanche(bench);
    add_robot_bench(bench);
    add_robot_distances_bench(bench);
    add_world(bench);
    add_environment(bench);
    add_distances(bench);
    add_self(bench);
    add_deform_bench(bench);
    add_dig(bench);
    add_shapes(bench);
    add_clash_bench(bench);
    add_read(bench);
    add_scene_bench(bench, "many", "Bunnies, dragons and cows in a cube");
    add_poses(bench);
    add_gpu(bench);
    add_scale(bench);
    add_any_scene_bench(bench);
    bench.footer(
        "Examples:\n"
        "  oncollide-lab bench many --bodies 1000 --exact fcl\n"
        "  oncollide-lab bench scene paper-5k --depth 5 --repeats 3 --timeline 100\n"
        "  oncollide-lab bench poses --depths 5-7\n"
        "  oncollide-lab bench broad --scene brown,static --sizes 1k,10k,100k --threads 1,2 --plot broad.svg\n"
        "  oncollide-lab bench narrow cup.obj spoon.stl --distances 0,1,10 --plot narrow.svg\n"
        "For reading and repeating results see docs/notes/benchmark-methods.md. Exit code 70: a collision was missed.");
}

} // namespace oncollide::tools
