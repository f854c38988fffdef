// A cloth of 5,000 triangles falls on a knot and comes to rest, without passing through the knot or itself.
// Usage: drape [cells of a side, default 50]. 100 cells make 20,000 triangles, which move on for longer.
#include <cstdio>
#include <cstdlib>

#include <oncollide/samples/cloth_solver.hpp>
#include <oncollide/samples/generators.hpp>

using namespace oncollide;

int main(int argc, char** argv)
{
    const int cells = argc > 1 ? std::atoi(argv[1]) : 50;
    World world({.threads = 0});
    const BodyId statue =
        world.bodies().add({.model = world.models().add(make_torus_knot_mesh(2, 3, 0.25, 0.1, 0.06, 20'000)),
                            .pose = Eigen::Isometry3d(Eigen::Translation3d(0, 0, -0.2)),
                            .is_static = true});
    const BodyId cloth = world.bodies().add({.model = world.models().add(make_sheet_mesh(1, cells))});
    example::ClothSolver solver(world, cloth, {statue});
    solver.thickness = 0.2 / cells, solver.reach = 0.4 / cells;
    int crossings = 0;
    for (int step = 0; step <= 800; ++step) {
        solver.step();
        for (const PairResult& pair : world.step().pairs) crossings += pair.verdict != Verdict::separate;
        crossings += !world.models().self_contacts(world.bodies().model(cloth), 1).empty();
        if (step % 100 > 0) continue;
        std::printf("%.1f s: %zu contacts, fastest %.1f mm/s, %d crossings\n", step * solver.dt, solver.contacts(),
                    1000 * solver.fastest(), crossings);
    }
    return crossings > 0;
}
