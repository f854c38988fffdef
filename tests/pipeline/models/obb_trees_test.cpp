// OBB trees are built if the memory budget allows, and their memory is returned.
#include <gtest/gtest.h>

#include <oncollide/pipeline/models/model_store.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide {
namespace {

constexpr std::size_t balls = 4;

/// Spheres of the same size in a row, far apart.
Scene row_of_balls()
{
    Scene scene;
    for (std::size_t i = 0; i < balls; ++i) {
        const std::string name = std::to_string(i);
        scene.add_body({.name = name, .geometry = scene.add(name, make_sphere_mesh(1, 500)), .motion = Drift{}});
        scene.set_position(SceneBodyId{std::uint32_t(i)}, {10 * double(i), 0, 0});
    }
    return scene;
}

TEST(ObbTrees, ReserveRoomUntilTheyAreDropped)
{
    const Scene scene = row_of_balls();
    const Mesh& mesh = std::get<Mesh>(scene.geometries[0].data);
    Settings settings;
    settings.age_limit = 2, settings.memory_budget = 5 * ObbTree::most_bytes(mesh.triangles.size()) / 2;
    ModelStore models(settings, make_cpu_backend());
    std::vector<Model*> balls_of;
    for (std::size_t i = 0; i < balls; ++i) balls_of.push_back(&models[models.add(scene.geometries.share(i))]);
    EXPECT_TRUE(models.admit_obb_tree(*balls_of[0], 0));
    EXPECT_TRUE(models.admit_obb_tree(*balls_of[1], 1));
    EXPECT_FALSE(models.admit_obb_tree(*balls_of[2], 1)) << "room for two";
    EXPECT_TRUE(models.admit_obb_tree(*balls_of[0], 1)) << "it exists already";
    EXPECT_TRUE(models.admit_obb_tree(*balls_of[1], 3));
    EXPECT_EQ(models.age(3), 1u) << "the root of one";
    EXPECT_FALSE(balls_of[0]->obb_tree());
    EXPECT_TRUE(models.admit_obb_tree(*balls_of[2], 3));
}

TEST(ObbTrees, OfAPairThatPartedMakeRoomForOthers)
{
    Scene scene = row_of_balls();
    const std::size_t bytes = ObbTree::most_bytes(std::get<Mesh>(scene.geometries[0].data).triangles.size());
    Settings settings;
    settings.exact = ExactLevel::predicates, settings.age_limit = 2, settings.memory_budget = 5 * bytes / 2;
    Pipeline pipeline(scene, settings);
    const auto pairs_tested = [&](std::size_t a, std::size_t b) {
        for (std::size_t i = 0; i < balls; ++i)
            scene.set_position(SceneBodyId{std::uint32_t(i)}, {10 * double(i), 0, 0});
        scene.set_position(SceneBodyId{std::uint32_t(b)}, scene.poses[a].translation() + Eigen::Vector3d(1.9, 0, 0));
        const FrameView frame = pipeline.step(scene);
        EXPECT_EQ(frame.pairs.size(), 1u);
        EXPECT_EQ(frame.pairs[0].verdict, frame.trees.triangle_pairs ? Verdict::colliding : Verdict::undecided);
        return frame.trees.triangle_pairs;
    };
    EXPECT_GT(pairs_tested(0, 1), 0u);
    EXPECT_EQ(pairs_tested(2, 3), 0u) << "no memory: a budget never changes which refiner decides";
    for (int frame = 0; frame < 3; ++frame) pairs_tested(2, 3);
    EXPECT_GT(pairs_tested(2, 3), 0u);
}

} // namespace
} // namespace oncollide
