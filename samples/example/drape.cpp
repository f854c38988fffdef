// A cloth of 5,000 triangles falls on a knot and comes to rest, without passing through the knot or itself.
// Usage: drape [cells of a side, default 50] [SCENE.json]. 100 cells make 20,000 triangles.
// With SCENE.json it also writes the motion as a scene for 'oncollide run', and its vertices beside it (SCENE.h5).
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include <oncollide/samples/cloth_solver.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

using namespace oncollide;

int main(int argc, char** argv)
try {
    const int cells = argc > 1 ? std::atoi(argv[1]) : 50;
    const std::filesystem::path file = argc > 2 ? argv[2] : "",
                                vertices = std::filesystem::path(file).replace_extension(".h5");
    Scene scene; // as the World has it at the start
    scene.name = "drape";
    scene.add("statue", make_torus_knot_mesh(2, 3, 0.25, 0.1, 0.06, 20'000));
    scene.add("cloth", make_sheet_mesh(1, cells));
    const Eigen::Isometry3d below(Eigen::Translation3d(0, 0, -0.2));
    scene.add_body({.name = "statue", .geometry = GeometryId{0}, .pose = below, .is_static = true});
    scene.add_body({.name = "cloth", .geometry = GeometryId{1}});

    World world({.threads = 0});
    const BodyId statue =
        world.bodies().add({.model = world.models().add(scene.geometries.share(0)), .pose = below, .is_static = true});
    const BodyId cloth = world.bodies().add({.model = world.models().add(scene.geometries.share(1))});
    example::ClothSolver solver(world, cloth, {statue});
    solver.thickness = 0.2 / cells, solver.reach = 0.4 / cells;
    std::optional<VertexFile> record;
    if (!file.empty()) record.emplace(vertices);
    constexpr int steps = 800, steps_of_frame = 4; // 50 frames per second
    int crossings = 0;
    for (int step = 0; step <= steps; ++step) {
        solver.step();
        for (const PairResult& pair : world.step().pairs) crossings += pair.verdict != Verdict::separate;
        crossings += !world.models().self_contacts(world.bodies().model(cloth), 1).empty();
        if (record && step % steps_of_frame == 0) record->add(solver.positions());
        if (step % 100 > 0) continue;
        std::printf("%.1f s: %zu contacts, fastest %.1f mm/s, %d crossings\n", step * solver.dt, solver.contacts(),
                    1000 * solver.fastest(), crossings);
    }
    if (record) {
        record->close();
        scene.deform(GeometryId{1}, open_vertices(vertices));
        scene.frames = steps / steps_of_frame + 1;
        save_scene(scene, file);
    }
    return crossings > 0;
} catch (const Error& error) {
    std::fprintf(stderr, "drape: %s\n", error.what());
    return static_cast<int>(error.kind());
}
