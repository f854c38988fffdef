// A ring and a gear; the gear moves through the ring, and each frame says what is certain about the two.
#include <iostream>

#include <oncollide/pipeline/pipeline.hpp>
#include <oncollide/scenes/catalogue/mesh_generators.hpp>

int main()
{
    using namespace oncollide;
    Scene scene;
    const GeometryId ring = scene.add("ring", make_torus_mesh(1.0, 0.3, 2000));
    const GeometryId gear = scene.add("gear", make_gear_mesh(12, 0.5, 0.6, 0.2, 0.1));
    scene.add_body({.name = "ring", .geometry = ring, .is_static = true});
    const BodyId moving = scene.add_body({.name = "gear", .geometry = gear});

    Pipeline pipeline(scene, {.max_error = 0.02});
    for (int frame = 0; frame <= 10; ++frame) {
        scene.poses[index(moving)].translation().x() = 0.2 * frame;
        for (const PairResult& pair : pipeline.step(scene).pairs)
            std::cout << "frame " << frame << ": " << scene.names[index(pair.a)] << " and "
                      << scene.names[index(pair.b)] << " are " << name_of(pair.verdict) << ", bound " << pair.bound
                      << " m\n";
    }
}
