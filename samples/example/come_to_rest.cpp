// Twenty concave meshes fall on hills and come to rest: manifolds, and the small solver of the samples.
#include <cstdio>

#include <oncollide/samples/generators.hpp>
#include <oncollide/samples/impulse_solver.hpp>

using namespace oncollide;

int main()
{
    constexpr double margin = 0.005;
    World world({.clearance = margin});
    example::ImpulseSolver solver(world);
    solver.dt = 0.004, solver.margin = margin, solver.friction = 0.8;
    const ModelId hills = world.models().add(make_hills(40, 40, 0.25, 0.5, 7));
    const ModelId gear = world.models().add(make_gear_mesh(6, 0.2, 0.3, 0.15, 0.08));
    solver.bodies.push_back({.id = world.bodies().add({.model = hills, .is_static = true})});
    for (int i = 0; i < 20; ++i) {
        Eigen::Isometry3d pose(Eigen::AngleAxisd(0.7 * i, Eigen::Vector3d(1, 0.3 * i, 0.2).normalized()));
        pose.translation() << 0.8 * (i % 5) + 3, 0.8 * (i / 5) + 3, 1.2;
        const BodyId id = world.bodies().add({.model = gear, .pose = pose});
        solver.bodies.push_back(example::box_body(id, {0.25, 0.25, 0.075}, 500));
    }
    for (int step = 0; step <= 1500; ++step) {
        solver.step();
        if (step % 250) continue;
        double fastest = 0, least = 1e9;
        for (const example::RigidBody& body : solver.bodies) {
            if (body.inverse_mass == 0) continue;
            fastest = std::max(fastest, body.velocity.norm());
            least = std::min(least, world.bodies().pose(body.id).translation().z());
        }
        std::printf("%.1f s: %zu points, deepest %.2f mm, fastest %.2f mm/s, lowest %.2f m\n", step * solver.dt,
                    solver.contacts(), 1000 * solver.deepest(), 1000 * fastest, least);
    }
}
