#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

#include "broadphase/boxes.hpp"

#include <oncollide/broadphase/aabb_checks.hpp>
#include <oncollide/broadphase/tree/aabb_tree.hpp>
#include <oncollide/broadphase/tree/pair_lists.hpp>

namespace oncollide {
namespace {

class EveryOrder : public testing::TestWithParam<AabbOrder> {
protected:
    static constexpr double margin = 0.125;

    /// Builds the tree of the first `count` boxes.
    void build(std::uint32_t count)
    {
        tree.build(scene.boxes, std::span(scene.all).first(count), margin, 1);
        bodies.assign(scene.all.begin(), scene.all.begin() + count);
    }
    std::string fault() const { return tree.validate(scene.columns(), margin, nullptr, 0); }
    /// The bodies whose boxes overlap `box`, as the tree finds them.
    Bodies found(const Aabb& box) const
    {
        Bodies hits;
        float rounded[6];
        tree.round(box, margin, rounded);
        find_in_chunks(
            [&](const std::uint32_t*, const std::uint32_t* places, std::size_t count) {
                for (std::size_t k = 0; k < count; ++k) hits.push_back(tree.body_at(places[k]));
            },
            [&](PairSink& sink) { aabb_tree_kernel().below_root(tree.view(), 0, rounded, sink); });
        std::ranges::sort(hits);
        return hits;
    }
    /// The tree finds each body that overlaps, and no body that is farther away than rounding.
    void expect_all_found()
    {
        for (std::uint32_t k = 0; k < 50; ++k) {
            const Aabb& box = scene.boxes[k * 17 % scene.boxes.size()];
            const Bodies hits = found(box);
            ASSERT_TRUE(std::ranges::adjacent_find(hits) == hits.end()) << "a body is found twice";
            for (std::uint32_t body : bodies) {
                const bool hit = std::ranges::binary_search(hits, body);
                ASSERT_TRUE(hit || !overlap(box, scene.boxes[body], margin)) << body;
                ASSERT_TRUE(!hit || overlap(box, scene.boxes[body], margin + 1e-3)) << body;
            }
        }
    }

    Boxes scene = random_boxes(1500, 25, 0.5, 5, {100, -200, 300});
    AabbTree tree{GetParam()};
    Bodies bodies; ///< in the tree
};

TEST_P(EveryOrder, HoldsEachBodyOnceAndFindsIt)
{
    for (const std::uint32_t count : {1u, 2u, 16u, 17u, 255u, 256u, 257u, 1500u}) {
        build(count);
        EXPECT_EQ(fault(), "") << count;
        EXPECT_EQ(tree.bodies(), count);
        for (std::uint32_t body : bodies) EXPECT_EQ(tree.body_at(tree.place_of(body)), body);
        expect_all_found();
    }
}

TEST_P(EveryOrder, FindsNoBodyThatWasErasedAndKeepsTheOthers)
{
    build(1500);
    Bodies gone;
    for (std::uint32_t body = 0; body < 1500; body += 3) gone.push_back(body);
    tree.erase(gone);
    std::erase_if(bodies, [](std::uint32_t body) { return body % 3 == 0; });
    EXPECT_EQ(fault(), "");
    EXPECT_EQ(tree.bodies(), bodies.size());
    for (std::uint32_t body : gone) EXPECT_FALSE(std::ranges::binary_search(found(scene.boxes[body]), body));
    expect_all_found();
}

TEST_P(EveryOrder, RebuildsForNewBodiesOnlyIfALevelIsMissing)
{
    build(200);
    const auto append = [&](std::uint32_t end) {
        const Bodies come(scene.all.begin() + std::ptrdiff_t(bodies.size()), scene.all.begin() + end);
        const bool rebuilt = tree.append(scene.boxes, come, margin, 1);
        bodies.assign(scene.all.begin(), scene.all.begin() + end);
        EXPECT_EQ(fault(), "") << end;
        return rebuilt;
    };
    EXPECT_FALSE(append(210));
    EXPECT_TRUE(append(700)) << "more than 256 slots need a third level";
    EXPECT_FALSE(append(701));
    EXPECT_FALSE(append(1500));
    expect_all_found();
}

TEST_P(EveryOrder, WidensBoundsForMovedBodiesUntilARefit)
{
    build(1500);
    const double before = tree.bounds(1, 0).volume();
    const std::uint32_t body = tree.body_at(0);
    const Aabb home = scene.boxes[body];
    const auto move_to = [&](const Aabb& box) {
        scene.boxes[body] = box;
        tree.refit_bodies(
            std::span(&body, 1), [&](std::uint32_t b) { return scene.boxes[b]; }, margin);
    };
    move_to({home.min.array() + 500, home.max.array() + 500});
    EXPECT_EQ(fault(), "");
    EXPECT_EQ(found(scene.boxes[body]), Bodies{body});
    move_to(home);
    EXPECT_EQ(fault(), "");
    EXPECT_GT(tree.bounds(1, 0).volume(), 100 * before);
    tree.refit(scene.boxes, margin, 1);
    EXPECT_EQ(fault(), "");
    EXPECT_EQ(tree.bounds(1, 0).volume(), before);
}

TEST_P(EveryOrder, IsDegradedOnceBodiesHaveLeftTheirNeighbours)
{
    build(1500);
    EXPECT_FALSE(tree.degraded());
    for (std::uint32_t body : bodies) scene.step(body, random_step(1, body, 1e-3));
    tree.refit(scene.boxes, margin, 1);
    EXPECT_FALSE(tree.degraded());
    for (std::uint32_t body : bodies) scene.step(body, random_step(2, body, 30));
    tree.refit(scene.boxes, margin, 1);
    EXPECT_TRUE(tree.degraded());
    build(1500);
    EXPECT_FALSE(tree.degraded());
}

TEST_P(EveryOrder, IsSureOfAnOverlapOnlyIfTheExactBoxesOverlap)
{
    build(1500);
    std::size_t sure = 0, overlapping = 0;
    for (std::uint32_t a : bodies)
        for (std::uint32_t b = a + 1; b < 1500; b += 7) {
            const bool surely = tree.surely_overlap(tree.place_of(a), tree.place_of(b));
            sure += surely, overlapping += overlap(scene.boxes[a], scene.boxes[b], margin);
            EXPECT_TRUE(!surely || overlap(scene.boxes[a], scene.boxes[b], margin)) << a << ' ' << b;
        }
    EXPECT_GT(sure, overlapping * 99 / 100);
    scene.boxes[1] = scene.boxes[0];
    scene.step(1, {scene.boxes[0].max.x() - scene.boxes[0].min.x() + margin + 1e-9, 0, 0});
    build(1500);
    EXPECT_FALSE(tree.surely_overlap(tree.place_of(0), tree.place_of(1))) << "they are a nanometre apart";
}

TEST_P(EveryOrder, FindsOnlyPairsWithAMovingBody)
{
    build(1500);
    std::vector<std::uint8_t> states(1500);
    for (std::uint32_t body = 0; body < 1500; body += 10) states[body] = 2;
    tree.set_moving(states.data(), 2);
    EXPECT_EQ(tree.validate(scene.columns(), margin, states.data(), 2), "");
    std::size_t pairs = 0;
    find_in_chunks(
        [&](const std::uint32_t* i, const std::uint32_t* j, std::size_t count) {
            for (std::size_t k = 0; k < count; ++k, ++pairs)
                EXPECT_TRUE(states[tree.body_at(i[k])] || states[tree.body_at(j[k])]);
        },
        [&](PairSink& sink) { aabb_tree_kernel().all(tree.view(), 0, sink); });
    EXPECT_GT(pairs, 100u);
    states[5] = 2; // without another set_moving()
    EXPECT_EQ(tree.validate(scene.columns(), margin, states.data(), 2),
              "body 5 moves, but is not marked in every node above it");
}

/// Each fault is planted in a whole tree.
TEST_P(EveryOrder, NamesTheFirstFaultOfADamagedTree)
{
    const auto fault_after = [&](auto damage) {
        build(1500);
        tree.set_filters(scene.columns(), {.layers = true});
        EXPECT_EQ(fault(), "");
        damage();
        return fault();
    };
    const auto has = [](const std::string& text, const char* words) { return text.find(words) != std::string::npos; };
    const auto blocks = [&](int level) { return const_cast<float*>(tree.view().level[level].blocks); };
    const Aabb home = scene.boxes[7];
    std::string text = fault_after([&] { scene.step(7, {0.5, 0, 0}); });
    EXPECT_TRUE(has(text, "does not enclose its body 7")) << text;
    scene.boxes[7] = home;
    text = fault_after([&] { blocks(1)[0] += 1; });
    EXPECT_EQ(text, "level 1, node 0: does not enclose a child");
    text = fault_after([&] { blocks(2)[node_width * 4] -= 1; });
    EXPECT_EQ(text, "level 2, node 0: does not enclose a child");
    text = fault_after([&] { blocks(0)[3 * node_width] = 3e8f; });
    EXPECT_EQ(text, "slot 0 is farther out than the farthest coordinate");
    text = fault_after([&] { scene.layers[3] |= 0x100; });
    EXPECT_TRUE(has(text, "lacks a layer of a child")) << text;
    scene.groups.assign(1500, 7);
    text = fault_after([&] {
        tree.set_filters(scene.columns(), {.groups = true});
        scene.groups[3] = 8;
    });
    EXPECT_TRUE(has(text, "lacks the group of a child")) << text;
}

/// All boxes overlap: without the marks there are more than a million pairs.
TEST_P(EveryOrder, SearchesNoPairsWithinOneGroup)
{
    build(1500);
    scene.boxes.assign(1500, scene.boxes[0]);
    tree.refit(scene.boxes, margin, 1);
    scene.groups.assign(1500, 7);
    const auto pairs = [&] {
        std::size_t found = 0;
        find_in_chunks([&](const std::uint32_t*, const std::uint32_t*, std::size_t count) { found += count; },
                       [&](PairSink& sink) { aabb_tree_kernel().all(tree.view(), 0, sink); });
        return found;
    };
    EXPECT_GT(pairs(), 1'000'000u);
    tree.set_filters(scene.columns(), {.groups = true});
    EXPECT_EQ(pairs(), 0u);
    scene.groups[3] = 8;
    tree.add_filters(3, scene.columns());
    EXPECT_EQ(fault(), "");
    EXPECT_GE(pairs(), 1499u);
    EXPECT_LT(pairs(), 32u * 1500) << "only the leaf of body 3 is searched";
    scene.groups[4] = 0; // in no group: pairs with all
    tree.add_filters(4, scene.columns());
    EXPECT_EQ(fault(), "");
    EXPECT_GE(pairs(), 2 * 1499u - 1);
    tree.set_filters(scene.columns(), {});
    EXPECT_GT(pairs(), 1'000'000u);
}

#ifdef ONCOLLIDE_ASSERTIONS
TEST_P(EveryOrder, DiesIfABodyIsErasedTwice)
{
    build(100);
    tree.erase(Bodies{9});
    EXPECT_DEATH(tree.erase(Bodies{9}), "contract broken");
}
#endif

INSTANTIATE_TEST_SUITE_P(AabbTree, EveryOrder, testing::Values(AabbOrder::kd, AabbOrder::octree),
                         [](const auto& order) { return order.param == AabbOrder::kd ? "kd" : "octree"; });

} // namespace
} // namespace oncollide
