// The contract: a stage may keep pairs that do not collide, but must never lose a pair that does. Whole
// pipelines are compared with the truth, at every depth and with each stage left out or replaced in turn.
#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/fcl/exact_fcl.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/samples/generators.hpp>

#include "truth/scene_truth.hpp"
#include "truth/setting_variants.hpp"

namespace oncollide::tools::contract_test {
namespace {

/// One variant for each text, which names changes of setting_changes().
std::vector<SettingVariant> variants_of(int depth, const std::vector<std::string>& changes)
{
    std::vector<SettingVariant> variants;
    for (const std::string& one : changes) variants.emplace_back("", Settings{.depth = depth}).change(one);
    return variants;
}

std::vector<SettingVariant> every_depth()
{
    std::vector<SettingVariant> variants;
    for (int depth = 1; depth <= 8; ++depth)
        variants.push_back({"depth " + std::to_string(depth), Settings{.depth = depth}});
    return variants;
}

/// The plain pipeline first, then one change at a time.
std::vector<SettingVariant> every_toggle(int depth)
{
    const std::string all_skipped =
        "without bounds, without delimitation, without broad, without refine, without exact";
    return variants_of(depth, {"",
                               "without bounds",
                               "without delimitation",
                               "without broad",
                               "without refine",
                               "without exact",
                               "octree",
                               "brute",
                               "exact fcl",
                               "exact fcl, without refine",
                               "exact predicates",
                               "exact predicates, without refine",
                               "exact predicates, sphere",
                               "exact predicates, clearance 0.05",
                               "exact predicates, 100 cells",
                               "exact predicates, solid",
                               "exact predicates, age 1",
                               "obb",
                               "obb, age 1",
                               "obb, clearance 0.05",
                               "obb, error 0.01",
                               "obb, exact fcl",
                               "obb, solid",
                               "obb, no memory",
                               "clearance 0.05",
                               "20 cells",
                               "no memory",
                               "age 1",
                               "solid",
                               all_skipped});
}

struct Play {
    int first = 0, frames = 3, every = 1;
    int bounds = 4; ///< to check per frame and variant
};

/// Every variant must keep all collisions, and every bound must hold for the true distance.
void judge(Scene scene, const std::vector<SettingVariant>& variants, Play play)
{
    Mover mover;
    mover.move(scene, play.first);
    Settings widest;
    for (const SettingVariant& v : variants) {
        widest.clearance = std::max(widest.clearance, v.settings.clearance);
        if (v.settings.mode == Mode::solid) widest.mode = Mode::solid;
    }
    SceneTruth truth(scene, widest);
    std::vector<Pipeline> pipelines;
    for (const SettingVariant& v : variants) pipelines.emplace_back(scene, v.settings);
    for (int f = 0; f < play.frames; ++f) {
        mover.move(scene, play.first + f * play.every);
        truth.step();
        for (std::size_t k = 0; k < variants.size(); ++k) {
            const FrameView frame = pipelines[k].step(scene);
            const FrameJudgement judged = judge(frame.pairs, truth, scene, variants[k].settings,
                                                {.bounds = std::size_t(play.bounds), .start = frame.frame + k});
            EXPECT_EQ(judged.missed + judged.wrong + judged.broken, 0u)
                << scene.name << ", " << variants[k].name << ", frame " << frame.frame << ": " << judged.first_fault;
        }
    }
}

Scene catalogue_scene(const char* name, int bodies = 0, std::uint64_t seed = 12345)
{
    CatalogueOptions options;
    if (bodies) options.bodies = bodies;
    options.seed = seed;
    return make_scene(name, options);
}

SceneBodyId put(Scene& scene, GeometryId geometry, const Eigen::Vector3d& position, double turn = 0)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = position;
    pose.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    return scene.add_body({.name = std::to_string(scene.size()), .geometry = geometry, .pose = pose});
}

TEST(Contract, NoCollisionOfThePapersAnimationIsLostAtAnyDepth)
{
    judge(catalogue_scene("paper"), every_depth(), {.frames = 60, .every = 40});
}

TEST(Contract, NoCollisionOfThePapersAnimationIsLostWithTheLargeMeshes)
{
    judge(catalogue_scene("paper-5k"), every_depth(), {.frames = 60, .every = 40, .bounds = 1});
}

TEST(Contract, NoCollisionOfThePapersAnimationIsLostWithAnyStageOff)
{
    judge(catalogue_scene("paper"), every_toggle(5), {.frames = 60, .every = 40});
}

TEST(Contract, NoCollisionAmongManyIsLostAtAnyDepth)
{
    judge(catalogue_scene("many", 100), every_depth(), {});
}

/// Small bodies far apart: most regions are empty, and the regions with bodies must survive.
TEST(Contract, NoCollisionOfATownIsLostWithAnyStageOff)
{
    judge(catalogue_scene("city", 500), every_toggle(3), {.frames = 2, .every = 20, .bounds = 2});
}

/// Delimitation is effective if little moves: here it must keep pillars with a ring on them, in groups and alone.
TEST(Contract, NoCollisionAmongPillarsIsLostWithAnyStageOff)
{
    Scene scene;
    scene.name = "pillars";
    const GeometryId pillar = scene.add("pillar", make_box_mesh({0.3, 0.3, 2}));
    const GeometryId ring = scene.add("ring", make_torus_mesh(0.8, 0.15, 300));
    const Eigen::Vector3d half(40, 40, 2);
    for (std::uint64_t i = 0; i < 460; ++i) {
        Eigen::Vector3d position, velocity;
        for (int axis = 0; axis < 3; ++axis) {
            position[axis] = half[axis] * (2 * u01(7, i, std::uint64_t(axis)) - 1);
            velocity[axis] = 2 * u01(7, i, 3 + std::uint64_t(axis)) - 1;
        }
        BodyInit body{.name = "pillar " + std::to_string(i), .geometry = pillar};
        body.pose.translation() << position.head<2>(), 0;
        if (i % 5 == 0) { // mixes bodies of both kinds in their numbering
            body.name = "ring " + std::to_string(i), body.geometry = ring;
            body.pose.translation() = position;
            body.motion = Drift{velocity, 0.2 * velocity, {-half, half}};
        }
        body.is_static = i % 5 != 0;
        scene.add_body(std::move(body));
    }
    judge(scene, every_toggle(4), {.frames = 10});
}

TEST(Contract, NoCollisionAmongManyIsLostWithAnyStageOff)
{
    judge(catalogue_scene("many", 100), every_toggle(6), {});
}

class RandomScenes : public testing::TestWithParam<int> {};

TEST_P(RandomScenes, LoseNoCollisionAtAnyDepth)
{
    judge(catalogue_scene("random", 16, std::uint64_t(GetParam())), every_depth(), {.every = 3, .bounds = 3});
}

TEST_P(RandomScenes, LoseNoCollisionWithAnyStageOff)
{
    const int depth = 1 + GetParam() % 8;
    judge(catalogue_scene("random", 16, std::uint64_t(GetParam())), every_toggle(depth), {.every = 3, .bounds = 2});
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomScenes, testing::Range(1, 13));

TEST(Contract, OneMeshTwiceAtOnePoseCollidesAtEveryDepth)
{
    for (double far : {0.0, 1e6}) {
        Scene scene;
        scene.name = far > 0 ? "twins far away" : "twins";
        const Eigen::Vector3d origin = Eigen::Vector3d::Constant(far);
        const GeometryId kinds[] = {scene.add("knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.2, 600)),
                                    scene.add("needles", make_needles_mesh(50, 1, 1e5, 2, 7)),
                                    scene.add("terrain", make_terrain_mesh(2, 0.3, 12, 7))};
        for (int k = 0; k < 3; ++k)
            for (int twin = 0; twin < 2; ++twin) put(scene, kinds[k], origin + Eigen::Vector3d(5 * k, 0, 0), 0.7 * k);
        judge(scene, every_depth(), {.frames = 2});
        judge(scene, every_toggle(7), {.frames = 2});
    }
}

/// Moves body 1 along a ray towards body 0 until FCL reports the first collision. False if they never collide.
bool push_until_touching(Scene& scene, const Eigen::Vector3d& direction, double reach)
{
    const auto of_0 = make_fcl_model(scene.geometries[0].data), of_1 = make_fcl_model(scene.geometries[1].data);
    const Eigen::Vector3d origin = scene.poses[0].translation();
    const auto collide = [&](double t) {
        scene.set_position(SceneBodyId{1}, origin + t * direction);
        return fcl_collides(*of_0, scene.poses[0], *of_1, scene.poses[1]);
    };
    constexpr int scan = 100;
    int k = scan;
    while (k >= 0 && !collide(reach * k / scan)) --k;
    if (k < 0 || k == scan) return false;
    double touching = reach * k / scan, apart = reach * (k + 1) / scan;
    for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (touching + apart);
        (collide(middle) ? touching : apart) = middle;
    }
    return collide(touching);
}

/// A contact at one point is lost by a hole in a tree.
TEST(Contract, BodiesThatBarelyTouchCollideAtEveryDepth)
{
    const std::vector<Mesh> meshes{make_torus_knot_mesh(2, 3, 0.6, 0.25, 0.12, 900),
                                   make_gear_mesh(9, 0.8, 1, 0.3, 0.3),
                                   make_sphere_mesh(0.7, 500),
                                   make_needles_mesh(60, 0.8, 1e4, 1.2, 3),
                                   make_terrain_mesh(2, 0.5, 14, 5),
                                   make_soup_mesh(80, 0.4, 1, 9),
                                   make_box_mesh({0.9, 0.2, 0.5}),
                                   make_torus_mesh(0.8, 0.15, 700)};
    int touching = 0;
    for (std::uint64_t seed = 1; seed <= 150; ++seed) {
        const auto draw = [&](std::uint64_t k) { return u01(seed, 0, k); };
        Scene scene;
        scene.name = "barely touching " + std::to_string(seed);
        for (std::uint64_t body = 0; body < 2; ++body) {
            const auto kind = std::size_t(draw(body) * double(meshes.size()));
            put(scene, scene.add("mesh " + std::to_string(body), meshes[kind]), {0, 0, 0}, 3 * draw(2 + body));
        }
        const Eigen::Vector3d direction =
            Eigen::Vector3d(2 * draw(4) - 1, 2 * draw(5) - 1, 2 * draw(6) - 1).normalized();
        if (!push_until_touching(scene, direction, 4)) continue;
        ++touching;
        judge(scene, every_depth(), {.frames = 1});
    }
    EXPECT_GT(touching, 100);
}

/// Coordinates are small multiples of powers of two: the boxes touch exactly.
TEST(Contract, BoxesThatOnlyTouchCollideAtEveryDepth)
{
    for (const bool as_shape : {false, true}) {
        Scene scene;
        scene.name = as_shape ? "touching box shapes" : "touching box meshes";
        const Eigen::Vector3d half(0.5, 0.25, 0.5);
        const GeometryId box = as_shape ? scene.add("box", Box{half}) : scene.add("box", make_box_mesh(half));
        put(scene, box, {0, 0, 0});
        put(scene, box, {1, 0, 0});      // face on face
        put(scene, box, {0.25, 0.5, 0}); // face on part of a face
        put(scene, box, {-1, 0.5, 0});   // edge on edge
        put(scene, box, {-1, -0.5, 1});  // corner on corner
        judge(scene, every_depth(), {.frames = 2});
        judge(scene, every_toggle(6), {.frames = 2});
        SceneTruth truth(scene, {});
        truth.step();
        EXPECT_GE(truth.colliding().size(), 4u);
    }
}

/// In solid mode the pipeline must also detect the inside, with certainty.
TEST(Contract, ABodyInsideAnotherCollidesInSolidModeOnly)
{
    Scene scene;
    scene.name = "nested";
    put(scene, scene.add("shell", make_sphere_mesh(2, 800)), {0, 0, 0});
    put(scene, scene.add("core", make_sphere_mesh(0.5, 200)), {0.25, 0, 0});
    Settings settings{.depth = 6};
    EXPECT_EQ(Pipeline(scene, settings).step(scene).pairs.front().verdict, Verdict::separate);
    settings.mode = Mode::solid;
    EXPECT_EQ(Pipeline(scene, settings).step(scene).pairs.front().verdict, Verdict::colliding);
}

TEST(Contract, ThreadsCoherenceAgeingAndBroadPhaseDoNotChangeTheHash)
{
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        Scene scene = catalogue_scene("random", 40, seed);
        std::vector<SettingVariant> variants = variants_of(6, {""});
        for (const SettingChange& change : changes_of_method())
            variants.push_back(variants_of(6, {change.name}).front());
        std::vector<std::uint64_t> hashes;
        for (const SettingVariant& v : variants) {
            Mover mover;
            Pipeline pipeline(scene, v.settings);
            for (int frame = 0; frame < 6; ++frame) {
                mover.move(scene, frame);
                pipeline.step(scene);
            }
            hashes.push_back(pipeline.hash());
            EXPECT_EQ(hashes.back(), hashes.front()) << "seed " << seed << ", " << v.name;
        }
    }
}

} // namespace
} // namespace oncollide::tools::contract_test
