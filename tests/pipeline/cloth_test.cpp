// A cloth of the samples' solver falls on a knot, passes through nothing, and comes to rest.
#include <gtest/gtest.h>

#include <oncollide/samples/cloth_solver.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide {
namespace {

TEST(Cloth, ComesToRestOnAKnotWithoutACrossing)
{
    constexpr int cells = 24;
    World world({.threads = 2});
    constexpr double drop = 0.2; // from the cloth to the knot's middle
    const BodyId knot =
        world.bodies().add({.model = world.models().add(make_torus_knot_mesh(2, 3, 0.25, 0.1, 0.06, 2000)),
                            .pose = Eigen::Isometry3d(Eigen::Translation3d(0, 0, -drop)),
                            .is_static = true});
    const ModelId model = world.models().add(make_sheet_mesh(1, cells));
    const BodyId cloth = world.bodies().add({.model = model});
    example::ClothSolver solver(world, cloth, {knot});
    solver.thickness = 0.2 / cells, solver.reach = 0.4 / cells;
    std::size_t most = 0;
    for (int step = 0; step < 800; ++step) {
        solver.step();
        most = std::max(most, solver.contacts());
        for (const PairResult& pair : world.step().pairs) ASSERT_EQ(pair.verdict, Verdict::separate) << step;
        ASSERT_TRUE(world.models().self_contacts(model, 1).empty()) << step;
    }
    EXPECT_GT(most, 100u);
    EXPECT_LT(solver.fastest(), 0.01);
    double lowest = 1;
    for (const Eigen::Vector3d& p : solver.positions()) lowest = std::min(lowest, p.z());
    EXPECT_GT(lowest, -0.6 - drop) << "the knot holds it";
    EXPECT_LT(lowest, -drop) << "its corners hang down";
}

} // namespace
} // namespace oncollide
