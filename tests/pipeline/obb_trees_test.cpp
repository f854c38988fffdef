// Trees of oriented boxes come with the room they are given, and give it back.
#include <gtest/gtest.h>

#include <oncollide/pipeline/obb_trees.hpp>
#include <oncollide/pipeline/pipeline.hpp>
#include <oncollide/scenes/catalogue/mesh_generators.hpp>

namespace oncollide {
namespace {

constexpr std::size_t balls = 4;

/// Balls of the same size in a row, far apart.
Scene row_of_balls()
{
    Scene scene;
    for (std::size_t i = 0; i < balls; ++i) {
        const std::string name = std::to_string(i);
        scene.add_body({.name = name, .geometry = scene.add(name, make_sphere_mesh(1, 500)), .motion = Drift{}});
        scene.poses[i].translation().x() = 10 * double(i);
    }
    return scene;
}

TEST(ObbTrees, ReserveRoomUntilTheyAreDropped)
{
    const Scene scene = row_of_balls();
    ObbTrees trees(scene);
    const Mesh& mesh = std::get<Mesh>(scene.geometries[0].data);
    const ObbTrees::Room room{ObbTree::most_nodes(mesh), ObbTree::most_bytes(mesh)};
    EXPECT_FALSE(trees.admit(scene.geometry[0], 0, {room.nodes - 1, room.bytes}));
    EXPECT_FALSE(trees.admit(scene.geometry[0], 0, {room.nodes, room.bytes - 1}));
    EXPECT_EQ(trees.reserved().nodes, 0u);
    for (const std::uint32_t frame : {0u, 1u}) EXPECT_TRUE(trees.admit(scene.geometry[frame], frame, room));
    EXPECT_TRUE(trees.admit(scene.geometry[0], 1, {})) << "it is there already";
    EXPECT_TRUE(trees.admit(scene.geometry[2], 3, room));
    EXPECT_EQ(trees.reserved().nodes, 3 * room.nodes);
    EXPECT_EQ(trees.reserved().bytes, 3 * room.bytes);
    EXPECT_EQ(trees.drop(3, 2), 2u) << "the roots of two";
    EXPECT_EQ(trees.reserved().nodes, room.nodes);
    EXPECT_EQ(trees.reserved().bytes, room.bytes);
}

TEST(ObbTrees, OfAPairThatPartedMakeRoomForOthers)
{
    Scene scene = row_of_balls();
    const std::size_t bytes = ObbTree::most_bytes(std::get<Mesh>(scene.geometries[0].data));
    Settings settings;
    settings.exact = ExactLevel::predicates, settings.age_limit = 2, settings.memory_budget = 5 * bytes / 2;
    Pipeline pipeline(scene, settings);
    const auto pairs_tested = [&](std::size_t a, std::size_t b) {
        for (std::size_t i = 0; i < balls; ++i) scene.poses[i].translation().x() = 10 * double(i);
        scene.poses[b].translation() = scene.poses[a].translation() + Eigen::Vector3d(1.9, 0, 0);
        const FrameView frame = pipeline.step(scene);
        EXPECT_EQ(frame.pairs.size(), 1u);
        EXPECT_EQ(frame.pairs[0].verdict, Verdict::colliding);
        return frame.trees.triangle_pairs;
    };
    EXPECT_GT(pairs_tested(0, 1), 0u);
    EXPECT_EQ(pairs_tested(2, 3), 0u) << "no room: FCL is asked";
    for (int frame = 0; frame < 3; ++frame) pairs_tested(2, 3);
    EXPECT_GT(pairs_tested(2, 3), 0u);
}

} // namespace
} // namespace oncollide
