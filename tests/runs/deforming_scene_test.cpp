// Scenes with meshes that deform, played by Pipeline.
#include <set>
#include <span>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/two_geometries.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/scenes/flutter.hpp>

namespace oncollide::deforming_scene_test {
namespace {

std::uint64_t run(Scene scene, const Settings& settings, int frames)
{
    Pipeline pipeline(scene, settings);
    Mover mover;
    for (int frame = 0; frame < frames; ++frame) mover.move(scene, frame), pipeline.step(scene);
    return pipeline.hash();
}

TEST(DeformingScene, FindsWhatMeshesThatDeformMeetInEachFrame)
{
    Scene scene = make_scene("flags", {.bodies = 16});
    Pipeline pipeline(scene);
    Mover mover;
    std::set<std::pair<std::uint32_t, std::uint32_t>> ever, first;
    for (int frame = 0; frame < 80; ++frame) {
        mover.move(scene, frame);
        std::set<std::pair<std::uint32_t, std::uint32_t>> found, expected;
        for (const PairResult& pair : pipeline.step(scene).pairs)
            if (pair.verdict == Verdict::colliding) found.insert({pair.a.slot, pair.b.slot});
        for (std::uint32_t a = 0; a < scene.size(); ++a)
            for (std::uint32_t b = a + 1; b < scene.size(); ++b) {
                if ((scene.is_static[a] && scene.is_static[b]) ||
                    (scene.groups[a] && scene.groups[a] == scene.groups[b]))
                    continue;
                const auto &of_a = scene.geometries.share(index(scene.geometry[a])),
                           &of_b = scene.geometries.share(index(scene.geometry[b]));
                if (collide(of_a, scene.poses[a], of_b, scene.poses[b]).verdict == Verdict::colliding)
                    expected.insert({a, b});
            }
        EXPECT_EQ(found, expected) << "frame " << frame;
        ever.insert(found.begin(), found.end());
        if (frame == 0) first = found;
    }
    EXPECT_GT(ever.size(), first.size()) << "some collide only later";
}

TEST(DeformingScene, GivesMeshesThatDeformTheSameHashForAnyThreadCountAndFirstFrame)
{
    const Scene scene = make_scene("flags", {.bodies = 40});
    const std::uint64_t expected = run(scene, {}, 40);
    EXPECT_EQ(run(scene, {}, 40), expected);
    for (const Settings& other : {Settings{.threads = 2}, Settings{.threads = 4}, Settings{.coherence = false},
                                  Settings{.broad_phase = BroadPhaseKind::brute_force}})
        EXPECT_EQ(run(scene, other, 40), expected);
    for (const Settings& settings : {Settings{.max_error = 0.02}, Settings{.depth = 5}, Settings{.clearance = 0.1}}) {
        Settings threads = settings;
        threads.threads = 3;
        EXPECT_EQ(run(scene, threads, 40), run(scene, settings, 40));
    }
    const auto frame_30 = [&](int first) {
        Scene played = scene;
        Pipeline pipeline(played);
        Mover mover;
        std::uint64_t hash = 0;
        for (int frame = first; frame <= 30; ++frame) mover.move(played, frame), hash = pipeline.step(played).hash;
        return hash;
    };
    for (const int first : {10, 29, 30}) EXPECT_EQ(frame_30(first), frame_30(0)) << first;
}

TEST(DeformingScene, PassesOnOnlyVerticesThatHaveChanged)
{
    Scene scene = make_scene("flags", {.bodies = 4});
    scene.pace = 0; // nothing moves
    Pipeline pipeline(scene);
    Mover mover;
    const auto vertices = [&] { return &pipeline.world().models().geometry(pipeline.model(GeometryId{0})); };
    const Geometry* const before = vertices();
    mover.move(scene, 0), pipeline.step(scene);
    const std::uint64_t traversed = pipeline.step(scene).trees.node_pairs;
    EXPECT_EQ(traversed, 0u) << "every gap is remembered";
    scene.pace = 1;
    mover.move(scene, 9), pipeline.step(scene);
    EXPECT_EQ(vertices(), before) << "the model stays";
    EXPECT_EQ(std::get<Mesh>(vertices()->data).vertices, std::get<Mesh>(scene.geometries[0].data).vertices);
}

TEST(DeformingScene, RefusesContactsOnTheWayOfMeshesThatDeform)
{
    Scene scene = make_scene("flags", {.bodies = 4});
    Pipeline pipeline(scene);
    pipeline.step(scene);
    pipeline.set_continuous(true);
    EXPECT_THROW(pipeline.step(scene), Error);
    pipeline.set_continuous(false);
    pipeline.step(scene);
    Scene later = make_scene("hard");
    Pipeline continuous(later);
    continuous.set_continuous(true);
    continuous.step(later);
    const Scene flags = make_scene("flags", {.bodies = 4});
    later.deform(later.add("cloth", flags.geometries.at_rest(0).data), std::make_shared<Flutter>());
    EXPECT_THROW(continuous.step(later), Error);
}

} // namespace
} // namespace oncollide::deforming_scene_test
