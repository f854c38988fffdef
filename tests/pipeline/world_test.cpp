// A World whose bodies are added, removed and changed gives the results of a new World.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/world.hpp>

#include "pipeline/knots.hpp"
#include "random_pose.hpp"

namespace oncollide::world_test {
namespace {

/// Verdicts of the pairs that are not separate, by their bodies' user numbers.
using Outcome = std::map<std::pair<std::uint64_t, std::uint64_t>, Verdict>;

Outcome outcome_of(World& world)
{
    Outcome outcome;
    for (const PairResult& pair : world.step().pairs) {
        if (pair.verdict == Verdict::separate) continue;
        const std::uint64_t a = world.bodies().user(pair.a), b = world.bodies().user(pair.b);
        outcome[{std::min(a, b), std::max(a, b)}] = pair.verdict;
    }
    return outcome;
}

/// The properties of a body, to add it to another World.
struct Described {
    BodySpec spec;
    std::size_t mesh;
    BodyId id;
};

TEST(World, RefinesThePairsThatItsFilterChoosesInTheOrderThatItChooses)
{
    World world({.clearance = 0.25, .exact = ExactLevel::predicates});
    const ModelId ball = world.models().add(Sphere{1}), knots = world.models().add(knot());
    std::vector<BodyId> bodies;
    for (std::uint64_t i = 0; i < 60;
         ++i) // a row in which each overlaps four others; more candidates than one call has
        for (int copies = 0; copies < 6; ++copies)
            bodies.push_back(
                world.bodies().add({.model = i % 3 ? ball : knots, .pose = at(0.75 * double(i)), .user = i}));
    const FrameView all = world.step();
    std::map<std::pair<BodyId, BodyId>, PairResult> results;
    for (const PairResult& pair : all.pairs) results[{pair.a, pair.b}] = pair;
    ASSERT_GT(results.size(), 4096u);

    std::vector<Aabb> boxes;
    for (const BodyId body : bodies)
        boxes.push_back(world.models().bounds(world.bodies().model(body), world.bodies().pose(body)));
    std::size_t offered = 0;
    world.set_pair_filter([&](std::span<const CandidatePair> pairs, std::span<PairChoice> choices) {
        ASSERT_EQ(pairs.size(), choices.size());
        offered += pairs.size();
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            const auto& [a, b, box_a, box_b] = pairs[i];
            ASSERT_EQ(choices[i], PairChoice::refine);
            ASSERT_LT(a.slot, b.slot);
            ASSERT_EQ(box_a.min, boxes[a.slot].min);
            ASSERT_EQ(box_b.max, boxes[b.slot].max);
            choices[i] = a.slot % 5 == 0 ? PairChoice::drop
                         : b.slot % 2    ? PairChoice::refine_swapped
                                         : PairChoice::refine;
        }
    });
    std::size_t expected = 0;
    for (const auto& [pair, result] : results) expected += pair.first.slot % 5 != 0;
    for (int frame = 0; frame < 2; ++frame) {
        offered = 0;
        const FrameView some = world.step();
        EXPECT_EQ(offered, results.size());
        EXPECT_EQ(some.pairs.size(), expected);
        EXPECT_TRUE(std::ranges::is_sorted(some.pairs, {}, [](const PairResult& p) { return std::pair(p.a, p.b); }));
        for (const PairResult& pair : some.pairs) {
            const bool swapped = pair.b < pair.a;
            const PairResult& whole = results.at(swapped ? std::pair(pair.b, pair.a) : std::pair(pair.a, pair.b));
            EXPECT_EQ(swapped, std::max(pair.a, pair.b).slot % 2 == 1);
            EXPECT_NE(std::min(pair.a, pair.b).slot % 5, 0u);
            EXPECT_EQ(pair.verdict, whole.verdict);
            EXPECT_NEAR(pair.bound, whole.bound, 1e-12);
        }
        if (frame == 1) {
            EXPECT_TRUE(some.began.empty() && some.ended.empty());
        }
    }
    const std::size_t hits = world.space().overlaps(PlacedModel{ball, at(0)}).size();
    world.set_pair_filter({});
    EXPECT_EQ(world.space().overlaps(PlacedModel{ball, at(0)}).size(), hits) << "a query depends on the filter";
    EXPECT_EQ(world.step().pairs.size(), results.size());
}

TEST(World, GivesAfterAnyChangesWhatAFreshOneGives)
{
    for (const BroadPhaseKind broad : {BroadPhaseKind::kd_tree, BroadPhaseKind::octree, BroadPhaseKind::brute_force})
        for (const ExactLevel exact : {ExactLevel::off, ExactLevel::predicates}) {
            const Settings settings{.depth = 4, .exact = exact, .broad_phase = broad};
            std::vector<Mesh> meshes{knot(), make_sphere_mesh(0.7, 200), make_box_mesh({0.4, 0.5, 0.6})};
            World world(settings);
            std::vector<ModelId> models;
            for (const Mesh& mesh : meshes) models.push_back(world.models().add(mesh));
            std::vector<Described> bodies;
            std::vector<std::pair<std::uint64_t, std::uint64_t>> excluded;
            std::uint64_t next = 0;
            std::mt19937_64 random(7);
            const auto below = [&](std::size_t n) { return std::size_t(random() % n); };
            const auto add = [&] {
                Described body{{}, below(meshes.size()), {}};
                body.spec = {.model = models[body.mesh],
                             .pose = random_pose(random() % 1000, 3.5),
                             .is_static = below(4) == 0,
                             .layer = below(5) ? 1u : 2u,
                             .group = std::uint32_t(below(6) ? 0 : 1 + below(2)),
                             .user = next++};
                body.id = world.bodies().add(body.spec);
                bodies.push_back(body);
            };
            for (int i = 0; i < 90; ++i) add();
            for (int frame = 0; frame < 12; ++frame) {
                for (int change = 0; change < 12; ++change) {
                    const std::size_t k = below(bodies.size());
                    Described& body = bodies[k];
                    switch (below(8)) {
                    case 0:
                        add();
                        break;
                    case 1:
                        world.bodies().remove(body.id);
                        std::erase_if(excluded, [&](const auto& pair) {
                            return pair.first == body.spec.user || pair.second == body.spec.user;
                        });
                        bodies.erase(bodies.begin() + std::ptrdiff_t(k));
                        break;
                    case 2:
                        world.bodies().set_static(body.id, body.spec.is_static = !body.spec.is_static);
                        break;
                    case 3:
                        body.spec.layer = 1u << below(2), body.spec.mask = 3u;
                        world.bodies().set_filter(body.id, {body.spec.layer, body.spec.mask, body.spec.group});
                        break;
                    case 4:
                        body.spec.group = std::uint32_t(below(3));
                        world.bodies().set_filter(body.id, {body.spec.layer, body.spec.mask, body.spec.group});
                        break;
                    case 5: {
                        const Described& other = bodies[(k + 1) % bodies.size()];
                        world.bodies().exclude(body.id, other.id);
                        excluded.emplace_back(body.spec.user, other.spec.user);
                        break;
                    }
                    case 6:
                        body.mesh = below(meshes.size());
                        world.bodies().set_model(body.id, body.spec.model = models[body.mesh]);
                        break;
                    default:
                        world.bodies().set_pose(body.id, body.spec.pose = random_pose(random() % 1000, 3.5));
                        break;
                    }
                }
                if (frame == 6) {
                    meshes[1] = make_torus_mesh(0.8, 0.2, 150);
                    world.models().replace(models[1], meshes[1]);
                }
                World fresh(settings);
                std::vector<ModelId> fresh_models;
                for (const Mesh& mesh : meshes) fresh_models.push_back(fresh.models().add(mesh));
                std::map<std::uint64_t, BodyId> ids;
                for (const Described& body : bodies) {
                    BodySpec spec = body.spec;
                    spec.model = fresh_models[body.mesh];
                    ids[spec.user] = fresh.bodies().add(spec);
                }
                for (const auto& [a, b] : excluded) fresh.bodies().exclude(ids[a], ids[b]);
                const Outcome expected = outcome_of(fresh);
                EXPECT_EQ(outcome_of(world), expected) << "frame " << frame;
                EXPECT_GT(expected.size(), 5u);
            }
        }
}

/// The broad phase rarely searches around bodies that drift; layers and groups may change at any time.
TEST(World, FollowsWhatMayCollideWhileBodiesDrift)
{
    for (const BroadPhaseKind broad : {BroadPhaseKind::kd_tree, BroadPhaseKind::octree}) {
        World world({.broad_phase = broad}), reference({.broad_phase = BroadPhaseKind::brute_force});
        std::mt19937 random(7);
        const auto below = [&](unsigned n) { return random() % n; };
        const auto filter = [&](BodySpec& spec) {
            spec.layer = 1u << below(2), spec.mask = 1 + below(3), spec.group = below(4) ? 0 : 1 + below(3);
        };
        const Shape ball = Sphere{0.5};
        const ModelId model = world.models().add(ball), model_there = reference.models().add(ball);
        struct Both {
            BodySpec spec;
            BodyId here, there;
        };
        std::vector<Both> bodies(400);
        const auto add = [&](Both& body) {
            body.spec.model = model, body.here = world.bodies().add(body.spec);
            BodySpec spec = body.spec;
            spec.model = model_there, body.there = reference.bodies().add(spec);
        };
        for (std::size_t i = 0; i < bodies.size(); ++i) {
            bodies[i].spec.pose = at(0.9 * double(i % 20), 0.9 * double(i / 20 % 20), 0.1 * below(3));
            bodies[i].spec.user = i;
            filter(bodies[i].spec);
            add(bodies[i]);
        }
        for (int frame = 0; frame < 60; ++frame) {
            for (std::size_t i = 0; i < bodies.size(); ++i) {
                Both& body = bodies[i];
                if (i % 10 == 3) {
                    body.spec.pose.translation().x() += frame / 15 % 2 ? -0.01 : 0.01;
                    world.bodies().set_pose(body.here, body.spec.pose),
                        reference.bodies().set_pose(body.there, body.spec.pose);
                }
                if (below(40)) continue;
                filter(body.spec);
                if (frame % 2) { // another body in its slot
                    world.bodies().remove(body.here), reference.bodies().remove(body.there);
                    add(body);
                } else {
                    const CollisionFilter filter{body.spec.layer, body.spec.mask, body.spec.group};
                    world.bodies().set_filter(body.here, filter), reference.bodies().set_filter(body.there, filter);
                }
            }
            ASSERT_EQ(outcome_of(world), outcome_of(reference)) << "frame " << frame;
        }
    }
}

TEST(World, CountsNoMemoryOfModelsThatWereRemoved)
{
    World world({.exact = ExactLevel::predicates});
    const auto come_and_go = [&] {
        const ModelId model = world.models().add(knot());
        const BodyId a = world.bodies().add({.model = model}),
                     b = world.bodies().add({.model = model, .pose = at(0.3)});
        EXPECT_EQ(world.step().pairs.size(), 1u);
        const std::size_t held = world.inspect().bytes;
        world.bodies().remove(a), world.bodies().remove(b), world.models().remove(model);
        world.step();
        EXPECT_LT(world.inspect().bytes, held) << "its boxes are removed";
        return world.inspect().bytes;
    };
    come_and_go(); // lets working memory grow
    const std::size_t once = come_and_go();
    for (int time = 0; time < 3; ++time) EXPECT_EQ(come_and_go(), once);
}

TEST(World, RefusesStaleIdsAndLeavesEverythingAsItWas)
{
    World world;
    const ModelId model = world.models().add(make_box_mesh({1, 1, 1}));
    const BodyId first = world.bodies().add({.model = model});
    EXPECT_THROW(world.models().remove(model), Error) << "a body uses it";
    world.bodies().remove(first);
    const BodyId second = world.bodies().add({.model = model});
    EXPECT_EQ(second.slot, first.slot);
    EXPECT_NE(second, first);
    EXPECT_THROW(world.bodies().set_pose(first, at(1)), Error);
    EXPECT_THROW(world.bodies().remove(first), Error);
    EXPECT_THROW(world.bodies().remove(std::vector{second, second}), Error);
    EXPECT_THROW(world.pairs().contacts(first, second), Error);
    EXPECT_TRUE(world.bodies().contains(second));
    EXPECT_FALSE(world.bodies().contains(first));
    Eigen::Isometry3d wrong = at(0);
    wrong.linear() *= 2;
    EXPECT_THROW(world.bodies().set_pose(second, wrong), Error);
    EXPECT_EQ(world.bodies().pose(second).matrix(), at(0).matrix());
    world.bodies().remove(second);
    world.models().remove(model);
    EXPECT_THROW(world.bodies().add({.model = model}), Error);
    Mesh broken = make_box_mesh({1, 1, 1});
    broken.triangles[3][1] = 77;
    EXPECT_THROW(world.models().add(broken), Error);
}

TEST(World, TellsWhichPairsBeganAndEnded)
{
    World world({.exact = ExactLevel::predicates});
    const ModelId model = world.models().add(make_box_mesh({1, 1, 1}));
    const BodyId a = world.bodies().add({.model = model}), b = world.bodies().add({.model = model, .pose = at(1.5)});
    const FrameView met = world.step();
    ASSERT_EQ(met.began.size(), 1u);
    EXPECT_EQ(met.began[0], (PairOfBodies{a, b}));
    const FrameView same = world.step();
    EXPECT_TRUE(same.began.empty() && same.ended.empty());
    world.bodies().set_pose(b, at(9));
    EXPECT_EQ(world.step().ended.size(), 1u);
    world.bodies().set_pose(b, at(1.5));
    world.step();
    world.bodies().remove(b);
    const BodyId c = world.bodies().add({.model = model, .pose = at(1.5)});
    ASSERT_EQ(c.slot, b.slot);
    const FrameView other = world.step();
    ASSERT_EQ(other.began.size(), 1u);
    ASSERT_EQ(other.ended.size(), 1u);
    EXPECT_EQ(other.began[0], (PairOfBodies{a, c}));
    EXPECT_EQ(other.ended[0], (PairOfBodies{a, b})) << "another body in the same slot";
}

/// The filter throws before any pair of the frame is decided.
TEST(World, ReportsTheEventsOfAFrameThatFailedInTheNextOne)
{
    World world;
    const ModelId model = world.models().add(make_box_mesh({1, 1, 1}));
    const BodyId a = world.bodies().add({.model = model}), b = world.bodies().add({.model = model, .pose = at(9)});
    world.step();
    world.bodies().set_pose(b, at(1.5));
    ASSERT_EQ(world.step().began.size(), 1u);
    world.bodies().set_pose(b, at(1.25));
    world.set_pair_filter([](auto, auto) { throw Error(ErrorKind::internal, "planted"); });
    EXPECT_THROW(world.step(), Error);
    world.set_pair_filter({});
    const FrameView next = world.step();
    EXPECT_TRUE(next.began.empty() && next.ended.empty()) << "they met before and after the failed frame";
    world.bodies().remove(a);
    EXPECT_EQ(world.step().ended.size(), 1u);
}

TEST(World, LetsBodiesSleepWithTheirResultsAndEvents)
{
    for (const bool budget : {false, true}) {
        World world({.memory_budget = budget ? 1'000'000'000u : 0u}); // so large that it changes no result
        const ModelId model = world.models().add(knot());
        std::vector<BodyId> ids;
        for (int i = 0; i < 6; ++i)
            ids.push_back(world.bodies().add({.model = model, .pose = at(i), .user = std::uint64_t(i)}));
        world.bodies().set_static(ids[0], true);
        world.bodies().sleep(std::span(ids).first(4));
        EXPECT_TRUE(world.bodies().is_asleep(ids[3]));
        EXPECT_FALSE(world.bodies().is_asleep(ids[4]));
        EXPECT_EQ(world.step().trees.kept, 0u) << "no pair has a result yet";
        const FrameView slept = world.step();
        EXPECT_TRUE(slept.began.empty() && slept.ended.empty());
        const auto asleep = std::ranges::count_if(
            slept.pairs, [](const PairResult& pair) { return pair.a.slot < 4 && pair.b.slot < 4; });
        EXPECT_GE(asleep, 3);
        EXPECT_EQ(slept.trees.kept, budget ? std::uint64_t(asleep) : slept.pairs.size());

        world.bodies().set_pose(ids[3], at(2.5)); // wakes it
        EXPECT_FALSE(world.bodies().is_asleep(ids[3]));
        World fresh(world.settings());
        const ModelId same = fresh.models().add(knot());
        for (int i = 0; i < 6; ++i)
            fresh.bodies().add({.model = same,
                                .pose = world.bodies().pose(ids[std::size_t(i)]),
                                .is_static = i == 0,
                                .user = std::uint64_t(i)});
        EXPECT_EQ(outcome_of(world), outcome_of(fresh));
        world.bodies().set_filter(ids[2], {.layer = 2, .mask = 2});
        EXPECT_FALSE(world.bodies().is_asleep(ids[2]));
        world.bodies().wake(ids[1]);
        EXPECT_FALSE(world.bodies().is_asleep(ids[1]));
        EXPECT_TRUE(world.bodies().is_asleep(ids[0])) << "static bodies may sleep, too";
        const FrameView left = world.step();
        EXPECT_TRUE(std::ranges::none_of(left.pairs,
                                         [](const PairResult& pair) { return pair.a.slot == 2 || pair.b.slot == 2; }));
        world.bodies().remove(ids[0]);
        EXPECT_THROW(world.bodies().sleep(ids), Error);
        EXPECT_FALSE(world.bodies().is_asleep(ids[4])) << "a refused call changes nothing";
        EXPECT_FALSE(world.bodies().is_asleep(world.bodies().add({.model = model})))
            << "in the slot of a body that slept";
    }
}

/// Rounding of the relative rotation used to separate them, after exact tests of every two neighbouring triangles.
TEST(World, FindsThatCopiesInOnePlaceCollide)
{
    World world({.exact = ExactLevel::predicates});
    const ModelId model = world.models().add(make_sphere_mesh(1, 5000));
    for (std::uint64_t k = 0; k < 20; ++k) {
        Eigen::Isometry3d pose = random_pose(k, 1);
        pose.translation().x() += 10 * double(k);
        world.bodies().add({.model = model, .pose = pose});
        world.bodies().add({.model = model, .pose = pose});
    }
    const FrameView frame = world.step();
    ASSERT_EQ(frame.pairs.size(), 20u);
    for (const PairResult& pair : frame.pairs) EXPECT_EQ(pair.verdict, Verdict::colliding);
}

} // namespace
} // namespace oncollide::world_test
