// Bodies that come to rest on manifolds, with a small impulse solver.
#include <chrono>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/samples/generators.hpp>
#include <oncollide/samples/impulse_solver.hpp>

namespace oncollide::rest_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Isometry3d at(const Vector3d& p)
{
    return Isometry3d(Eigen::Translation3d(p));
}

struct Moved {
    double creep = 0; ///< of any body, m/s, in the last fifth
    double tilt = 0;  ///< radians
    double depth = 0;
    std::size_t most_points = 0; ///< of a pair
    double ms = 0;               ///< of a step
};

Moved play(World& world, example::ImpulseSolver& solver, int steps)
{
    Moved moved;
    std::vector<Isometry3d> before;
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < steps; ++i) {
        if (i == steps - steps / 5) {
            before.clear();
            for (const auto& body : solver.bodies) before.push_back(world.bodies().pose(body.id));
        }
        solver.step();
        const ManifoldLists& lists = solver.manifolds();
        for (std::size_t k = 0; k + 1 < lists.offsets.size(); ++k) {
            std::size_t points = 0;
            for (std::size_t r = lists.offsets[k]; r < lists.offsets[k + 1]; ++r) points += lists.regions[r].count;
            if (i > steps / 2) moved.most_points = std::max(moved.most_points, points);
        }
        if (i > steps / 2) moved.depth = std::max(moved.depth, solver.deepest());
    }
    moved.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count() / steps;
    for (std::size_t i = 0; i < solver.bodies.size(); ++i) {
        const Isometry3d& now = world.bodies().pose(solver.bodies[i].id);
        moved.creep =
            std::max(moved.creep, (now.translation() - before[i].translation()).norm() / (steps / 5 * solver.dt));
        moved.tilt = std::max(moved.tilt, std::acos(std::clamp(now.linear()(2, 2), -1.0, 1.0)));
    }
    return moved;
}

TEST(Rest, AStackOfBoxesStandsWhateverItsTriangles)
{
    const Vector3d half(0.25, 0.25, 0.25);
    for (const int cells : {0, 1, 10}) { // 0: the shape
        World world({.clearance = 0.01, .threads = 1});
        example::ImpulseSolver solver(world);
        const ModelId ground = world.models().add(Shape(Box{{5, 5, 1}}));
        const ModelId box =
            cells ? world.models().add(make_box_mesh(half, cells)) : world.models().add(Shape(Box{half}));
        solver.bodies.push_back(
            {.id = world.bodies().add({.model = ground, .pose = at({0, 0, -1}), .is_static = true})});
        for (int i = 0; i < 5; ++i) {
            const Vector3d p(0.01 * (i % 2), 0.013 * (i % 3), 0.25 + 0.5 * i);
            solver.bodies.push_back(example::box_body(world.bodies().add({.model = box, .pose = at(p)}), half));
        }
        const Moved moved = play(world, solver, 800);
        const std::string where = fmt::format("{} cells: creep {} m/s, tilt {}, depth {}, {} points, {} ms", cells,
                                              moved.creep, moved.tilt, moved.depth, moved.most_points, moved.ms);
        RecordProperty(fmt::format("cells_{}", cells), where);
        EXPECT_LE(moved.creep, 1e-6) << where;
        EXPECT_LE(moved.tilt, 0.002) << where;
        EXPECT_LE(moved.depth, 5e-4) << where;
        EXPECT_LE(moved.most_points, 8u) << where;
        if (std::getenv("REST_SHOW")) puts(where.c_str());
    }
}

TEST(Rest, ABoxSlidesOverTrianglesAsOverAPlane)
{
    for (const int cells : {7, 100}) {
        World world({.clearance = 0.01, .threads = 1});
        example::ImpulseSolver solver(world);
        solver.friction = 0;
        const Vector3d half(0.25, 0.2, 0.1);
        Mesh ground = make_box_mesh({4, 4, 1}, cells);
        solver.bodies.push_back(
            {.id =
                 world.bodies().add({.model = world.models().add(ground), .pose = at({0, 0, -1}), .is_static = true})});
        solver.bodies.push_back(example::box_body(
            world.bodies().add({.model = world.models().add(make_box_mesh(half)), .pose = at({-2, 0.0123, 0.1})}),
            half));
        solver.bodies[1].velocity = {2, 0.3, 0};
        double sideways = 0, up = 0;
        for (int i = 0; i < 1000; ++i) {
            solver.step();
            if (i < 100) continue;
            sideways = std::max(sideways, std::abs(solver.bodies[1].velocity.y() - 0.3));
            up = std::max(up, std::abs(solver.bodies[1].velocity.z()));
        }
        const std::string where =
            fmt::format("{} cells: sideways {}, up {}, speed {}", cells, sideways, up, solver.bodies[1].velocity.x());
        EXPECT_LE(sideways, 1e-5) << where;
        EXPECT_LE(up, 1e-4) << where;
        EXPECT_NEAR(solver.bodies[1].velocity.x(), 2, 2e-5) << where;
        EXPECT_NEAR(world.bodies().pose(solver.bodies[1].id).translation().x(), 0, 1e-3) << where;
        if (std::getenv("REST_SHOW")) puts(where.c_str());
    }
}

TEST(Rest, ConcaveMeshesComeToRest)
{
    World world({.clearance = 0.01, .threads = 1});
    example::ImpulseSolver solver(world);
    solver.bodies.push_back(
        {.id = world.bodies().add(
             {.model = world.models().add(Shape(Box{{3, 3, 1}})), .pose = at({0, 0, -1}), .is_static = true})});
    solver.dt = 0.004, solver.margin = 0.005, solver.friction = 0.8;
    const ModelId gear = world.models().add(make_gear_mesh(8, 0.25, 0.35, 0.2, 0.1));
    for (int i = 0; i < 3; ++i) { // a fourth would lean over, and rock for ten seconds
        const Vector3d p(0.2 * (i % 2), 0.15 * (i % 3), 0.15 + 0.24 * i);
        solver.bodies.push_back(
            example::box_body(world.bodies().add({.model = gear, .pose = at(p)}), {0.35, 0.35, 0.1}, 300));
    }
    const Moved moved = play(world, solver, 1000);
    const std::string where =
        fmt::format("creep {} m/s, depth {}, {} points, {} ms", moved.creep, moved.depth, moved.most_points, moved.ms);
    EXPECT_LE(moved.creep, 1e-6) << where;
    EXPECT_LE(moved.depth, 2e-3) << where;
    for (const auto& body : solver.bodies) EXPECT_GT(world.bodies().pose(body.id).translation().z(), -1.5) << where;
    if (std::getenv("REST_SHOW")) puts(where.c_str());
}

} // namespace
} // namespace oncollide::rest_test
