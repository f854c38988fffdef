// The truth of 'oncollide accuracy study', its detection of wrong results, and its choice of the fastest engine for an
// error.
#include <functional>

#include <fmt/format.h>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/samples/generators.hpp>

#include "every_kind.hpp"
#include "narrowphase/mesh_parts.hpp"
#include "random_pose.hpp"
#include "study/play.hpp"

namespace oncollide::tools {
namespace {

Scene crowd()
{
    return make_scene("many", {.bodies = 150, .frames = 4, .data = {}});
}

Settings exact(Mode mode = Mode::surface, double clearance = 0)
{
    Settings settings;
    settings.exact = ExactLevel::predicates, settings.mode = mode, settings.clearance = clearance;
    return settings;
}

std::vector<BodyPair> colliding(std::span<const PairResult> pairs)
{
    std::vector<BodyPair> found;
    for (const PairResult& pair : pairs)
        if (pair.verdict != Verdict::separate) found.push_back({index(pair.a), index(pair.b)});
    return found;
}

Scene two(const Mesh& a, const Mesh& b)
{
    Scene scene;
    scene.add_body({.name = "a", .geometry = scene.add("a", a)});
    scene.add_body({.name = "b", .geometry = scene.add("b", b)});
    return scene;
}

TEST(StudyTruth, IsThatOfExactPredicatesInACrowd)
{
    for (const Settings& settings : {exact(), exact(Mode::solid), exact(Mode::surface, 0.05)}) {
        Scene scene = crowd();
        Pipeline pipeline(scene, settings);
        SceneTruth truth(scene, settings);
        Mover mover;
        std::size_t found = 0;
        for (int frame = 0; frame < scene.frames; ++frame) {
            mover.move(scene, frame);
            truth.step();
            EXPECT_EQ(truth.colliding(), colliding(pipeline.step(scene).pairs)) << frame;
            found += truth.colliding().size();
        }
        EXPECT_GT(found, 100u);
    }
}

/// Boxes and knots that touch, miss by an ulp or cross by one.
TEST(StudyTruth, IsThatOfExactPredicatesWhereBodiesNearlyTouch)
{
    const Mesh box = make_box_mesh({0.5, 0.5, 0.5}), knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300);
    std::size_t count[2][2] = {};
    for (const auto& [a, b] : {std::pair(&box, &box), std::pair(&knot, &box), std::pair(&knot, &knot)})
        for (const bool ignore : {false, true}) {
            Settings settings = exact();
            settings.ignore_touching = ignore;
            Scene scene = two(*a, *b);
            Pipeline pipeline(scene, settings);
            SceneTruth truth(scene, settings);
            const auto check = [&](const Eigen::Isometry3d& pose) {
                scene.set_pose(SceneBodyId{1}, pose);
                truth.step();
                const bool collide = !truth.colliding().empty();
                const FrameView view = pipeline.step(scene);
                if (truth.open({0, 1})) return collide; // an ulp deep: either result is right
                EXPECT_EQ(truth.colliding(), colliding(view.pairs)) << pose.matrix();
                ++count[ignore][collide];
                return collide;
            };
            for (std::uint64_t k = 0; k < 60; ++k) {
                Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
                // Multiples of a quarter, so that faces, edges and corners coincide.
                for (std::uint64_t axis = 0; axis < 3; ++axis)
                    pose.translation()[int(axis)] = 0.25 * std::floor(10 * u01(3, k, axis)) - 1.25;
                check(pose);
                for (double to : {-9.0, 9.0}) {
                    Eigen::Isometry3d off = pose;
                    off.translation().x() = std::nextafter(off.translation().x(), to);
                    check(off);
                }
            }
            // Rotated, on both sides of the pose in which they begin to touch.
            for (std::uint64_t k = 0; k < 10; ++k) {
                Eigen::Isometry3d in = random_pose(k, 0), out = in;
                out.translation() = Eigen::Vector3d(4, 1, 0);
                if (!check(in)) continue; // a hole
                for (int step = 0; step < 60; ++step) {
                    Eigen::Isometry3d middle = in;
                    middle.translation() = 0.5 * (in.translation() + out.translation());
                    (check(middle) ? in : out) = middle;
                }
            }
        }
    for (std::size_t ignore : {0, 1})
        for (std::size_t collide : {0, 1}) EXPECT_GT(count[ignore][collide], 200u);
}

TEST(StudyTruth, KnowsWhatLiesInsideWhat)
{
    const Mesh ball = make_sphere_mesh(0.2, 100), torus = make_torus_mesh(1, 0.45, 240),
               hollow = joined({make_sphere_mesh(1, 160), flipped(make_sphere_mesh(0.6, 100))}),
               apart = joined({make_sphere_mesh(0.1, 60), moved(make_sphere_mesh(0.1, 60), {3, 0, 0})});
    const auto collide = [](const Mesh& a, const Mesh& b, const Eigen::Vector3d& at, bool swapped) {
        Scene scene = swapped ? two(b, a) : two(a, b);
        scene.set_position(SceneBodyId{std::uint32_t(swapped ? 0 : 1)}, at);
        SceneTruth truth(scene, exact(Mode::solid));
        truth.step();
        return !truth.colliding().empty();
    };
    for (bool swapped : {false, true}) {
        EXPECT_FALSE(collide(torus, ball, {0, 0, 0}, swapped)) << "in its hole";
        EXPECT_TRUE(collide(torus, ball, {1, 0, 0}, swapped));
        EXPECT_FALSE(collide(hollow, ball, {0, 0, 0}, swapped));
        EXPECT_TRUE(collide(flipped(torus), ball, {1, 0, 0}, swapped));
        EXPECT_TRUE(collide(torus, apart, {1, 0, 0}, swapped));
        EXPECT_TRUE(collide(torus, apart, {-4, 0, 0}, swapped)) << "its second part";
        EXPECT_FALSE(collide(torus, apart, {0, 0, 0}, swapped));
    }
    Scene mixed;
    mixed.add_body({.name = "mesh", .geometry = mixed.add("mesh", make_sphere_mesh(1, 160))});
    mixed.add_body({.name = "shape", .geometry = mixed.add("shape", Shape(Sphere{0.2}))});
    for (Mode mode : {Mode::surface, Mode::solid}) {
        SceneTruth truth(mixed, exact(mode));
        truth.step();
        EXPECT_EQ(truth.colliding().empty(), mode == Mode::surface);
    }
}

TEST(StudyTruth, BoundsDistancesAsTheLibraryDoes)
{
    Scene scene = two(make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300), make_torus_mesh(1, 0.3, 200));
    SceneTruth truth(scene, exact());
    for (std::uint64_t k = 0; k < 60; ++k) {
        scene.set_pose(SceneBodyId{0}, random_pose(2 * k, 100)),
            scene.set_pose(SceneBodyId{1}, scene.poses[0] * random_pose(2 * k + 1, 3));
        truth.step();
        if (!truth.colliding().empty()) continue;
        const Pipeline pipeline(scene);
        const Distance found =
            pipeline.world().pairs().distance(pipeline.body(SceneBodyId{0}), pipeline.body(SceneBodyId{1}));
        const DistanceTruth distance = truth.distance({0, 1});
        EXPECT_LE(distance.low, found.upper);
        EXPECT_GE(distance.high, found.lower);
        EXPECT_NEAR(distance.low, distance.high, 1e-7);
    }
}

/// Every pair of kinds, in poses that touch, overlap and miss: the truth equals the exact level's result, and bounds
/// hold.
TEST(StudyTruth, KnowsEveryTwoKinds)
{
    std::size_t apart = 0, meet = 0, open = 0;
    for (std::size_t pair = 0; pair < kinds * kinds; ++pair)
        for (std::uint64_t i = 0; i < 6; ++i) {
            const std::uint64_t seed = 100 * pair + i;
            SCOPED_TRACE(fmt::format("{} and {}, case {}", every_kind[pair / kinds], every_kind[pair % kinds], i));
            Scene scene;
            scene.add_body({.geometry = scene.add("a", draw_geometry(pair / kinds, seed))});
            scene.add_body({.geometry = scene.add("b", draw_geometry(pair % kinds, seed + 1))});
            const bool on_grid = i % 2;
            for (std::uint32_t body : {0, 1}) {
                Eigen::Isometry3d pose = random_pose(2 * seed + body, 1.5);
                if (on_grid) {
                    pose.linear().setIdentity();
                    pose.translation() = (8 * pose.translation()).array().floor() / 8;
                }
                // Outside the finite piece that replaces a half-space elsewhere.
                if (i == 4) pose.translation() += Eigen::Vector3d(3e3, -2e3, 1e3);
                scene.set_pose(SceneBodyId{body}, pose);
            }
            const double clearance = i % 3 == 2 ? 0.25 : 0;
            SceneTruth truth(scene, exact(Mode::surface, clearance));
            truth.step();
            Pipeline pipeline(scene, exact(Mode::surface, clearance));
            const FrameView view = pipeline.step(scene);
            const bool collide = truth.collide({0, 1});
            if (truth.open({0, 1})) {
                ++open;
            } else {
                EXPECT_EQ(collide, !colliding(view.pairs).empty());
                ++(collide ? meet : apart);
            }
            if (view.pairs.empty()) continue;
            const DistanceTruth distance = truth.distance({0, 1});
            const double bound = view.pairs[0].bound;
            if (view.pairs[0].verdict == Verdict::separate) {
                EXPECT_LE(bound, distance.high);
            } else {
                EXPECT_GE(bound, collide && clearance == 0 ? 0 : distance.low);
            }
        }
    EXPECT_GT(apart, 150u);
    EXPECT_GT(meet, 200u);
    EXPECT_LT(open, 60u);
}

/// A sphere above a plane that is far larger.
TEST(StudyTruth, MeasuresHowFarBodiesAreOverAPlane)
{
    Scene scene;
    scene.add_body({.geometry = scene.add("plane", Shape(HalfSpace{}))});
    scene.add_body({.geometry = scene.add("ball", Shape(Sphere{0.5}))});
    SceneTruth truth(scene, exact());
    const auto at = [&](double height) {
        scene.set_position(SceneBodyId{1}, Eigen::Vector3d(1e6, -1e6, height));
        truth.step();
        return truth.distance({0, 1});
    };
    EXPECT_NEAR(at(0.51).low, 0.01, 1e-9);
    EXPECT_NEAR(at(0.51).high, 0.01, 1e-9);
    EXPECT_FALSE(truth.collide({0, 1}) || truth.open({0, 1}));
    EXPECT_EQ(at(0.49).low, 0);
    EXPECT_TRUE(truth.collide({0, 1}));
    EXPECT_EQ(at(-1e4).high, 0);
    EXPECT_TRUE(truth.collide({0, 1}));
}

TEST(StudyTruth, LeavesOpenWhatRoundingDecides)
{
    const Mesh cube = make_box_mesh({0.5, 0.5, 0.5});
    Scene scene = two(cube, cube);
    SceneTruth truth(scene, exact(Mode::surface, 0.1));
    const auto at = [&](double x) {
        scene.set_position(SceneBodyId{1}, {x, scene.poses.position(1).y(), scene.poses.position(1).z()});
        truth.step();
        return std::pair(!truth.colliding().empty(), truth.open({0, 1}));
    };
    EXPECT_EQ(at(1.1), std::pair(false, true));
    EXPECT_EQ(at(1.0999999), std::pair(true, false));
    EXPECT_EQ(at(1.1000001), std::pair(false, false));
}

/// Wrong results of every kind, planted among right ones.
TEST(StudyJudge, SeesWrongAnswersOfThePipeline)
{
    Scene scene = crowd();
    Settings settings;
    settings.depth = 3;
    Pipeline spheres(scene, settings), predicates(scene, exact());
    SceneTruth truth(scene, exact());
    truth.step();
    const auto pairs = [&](Pipeline& pipeline) {
        const FrameView view = pipeline.step(scene);
        return std::vector<PairResult>(view.pairs.begin(), view.pairs.end());
    };
    const std::vector<PairResult> right = pairs(predicates), wide = pairs(spheres);
    const auto judged = [&](std::vector<PairResult> answer, const std::function<bool(PairResult&)>& plant) {
        StudyRow row;
        row.variant.settings =
            std::ranges::any_of(answer, [](const PairResult& p) { return p.verdict == Verdict::within; }) ? settings
                                                                                                          : exact();
        for (PairResult& pair : answer)
            if (plant(pair)) break;
        judge(row, answer, truth, scene, 0);
        return row;
    };
    const auto nothing = [](PairResult&) { return true; };
    for (const auto& answer : {right, wide}) {
        const StudyRow row = judged(answer, nothing);
        EXPECT_FALSE(row.faulty());
    }
    EXPECT_GT(judged(wide, nothing).false_positives, 10u);

    const StudyRow missed = judged(right, [](PairResult& pair) {
        return pair.verdict == Verdict::colliding && (pair.verdict = Verdict::separate, true);
    });
    EXPECT_EQ(missed.missed, 1u);
    EXPECT_TRUE(missed.faulty());
    ASSERT_TRUE(missed.first_miss);
    EXPECT_TRUE(truth.collide(missed.first_miss->pair));

    std::vector<PairResult> fewer = right; // as if the broad phase had missed it
    std::erase_if(fewer, [&](const PairResult& pair) {
        return BodyPair{index(pair.a), index(pair.b)} == truth.colliding().back();
    });
    EXPECT_EQ(judged(fewer, nothing).missed, 1u);

    EXPECT_EQ(judged(right,
                     [](PairResult& pair) {
                         return pair.verdict == Verdict::separate && (pair.verdict = Verdict::colliding, true);
                     })
                  .wrong,
              1u);
    EXPECT_EQ(judged(wide,
                     [&](PairResult& pair) {
                         const BodyPair bodies{index(pair.a), index(pair.b)};
                         if (pair.verdict != Verdict::within || truth.collide(bodies)) return false;
                         pair.bound = 0.99 * truth.distance(bodies).high;
                         return true;
                     })
                  .broken,
              1u);
}

TEST(StudyFront, IsOfThoseThatAreRight)
{
    Study study;
    const auto row = [](double ms, double error) {
        StudyRow made;
        made.ms = {ms}, made.error = error;
        return made;
    };
    const auto peer = [](double ms, std::uint64_t missed, std::uint64_t invented) {
        StudyPeer made;
        made.ms = {ms}, made.missed = missed, made.invented = invented;
        return made;
    };
    study.rows = {row(1, 0.1), row(2, 0.2), row(9, 0), row(0.1, 0)};
    study.rows[3].wrong = 1;
    study.peers = {peer(10, 0, 0), peer(0.2, 1, 0), peer(0.2, 0, 1)};
    const auto front = [&] {
        std::vector<int> on;
        for (const StudyRow& r : study.rows) on.push_back(on_front(study, r));
        for (const StudyPeer& p : study.peers) on.push_back(on_front(study, p));
        return on;
    };
    EXPECT_EQ(front(), (std::vector<int>{1, 0, 1, 0, 0, 0, 0}));
    study.peers[0].ms = {8};
    EXPECT_EQ(front(), (std::vector<int>{1, 0, 0, 0, 1, 0, 0})) << "a peer beats the exact row";
    study.peers[0].ms = {0.5};
    EXPECT_EQ(front(), (std::vector<int>{0, 0, 0, 0, 1, 0, 0})) << "and all others";
}

} // namespace
} // namespace oncollide::tools
