// A gear moves through a ring. Prints each frame's certified result for the pair.
#include <iostream>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

int main()
{
    using namespace oncollide;
    World world({.max_error = 0.02});
    const ModelId ring = world.models().add(make_torus_mesh(1.0, 0.3, 2000));
    const ModelId gear = world.models().add(make_gear_mesh(12, 0.5, 0.6, 0.2, 0.1));
    world.bodies().add({.model = ring, .is_static = true});
    const BodyId moving = world.bodies().add({.model = gear});

    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (int frame = 0; frame <= 10; ++frame) {
        pose.translation().x() = 0.2 * frame;
        world.bodies().set_pose(moving, pose);
        for (const PairResult& pair : world.step().pairs)
            std::cout << "frame " << frame << ": ring and gear are " << name_of(pair.verdict) << ", bound "
                      << pair.bound << " m\n";
    }
}
