#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/dynamic_tree.hpp>

#include "boxes.hpp"

namespace oncollide {
namespace {

using Bodies = std::vector<std::uint32_t>;
using Pairs = std::vector<BodyPair>;

BodyColumns columns(const Boxes& scene)
{
    return {scene.boxes, scene.layers, scene.masks};
}

Pairs find(DynamicTree& tree, const Boxes& scene)
{
    const auto pairs = tree.find_pairs(columns(scene));
    return {pairs.begin(), pairs.end()};
}

DynamicTree tree_of(const Boxes& scene, const DynamicTree::Options& options = {})
{
    DynamicTree tree(options);
    Bodies resting, moving;
    for (std::uint32_t body : scene.all) (scene.is_static[body] ? resting : moving).push_back(body);
    tree.add(resting, true), tree.add(moving);
    return tree;
}

void step(Boxes& scene, std::uint32_t body, const Eigen::Vector3d& by)
{
    scene.boxes[body].min += by, scene.boxes[body].max += by;
}

Eigen::Vector3d random_step(std::uint64_t frame, std::uint32_t body, double reach)
{
    return reach * (Eigen::Vector3d(u01(frame, body, 1), u01(frame, body, 2), u01(frame, body, 3)).array() - 0.5);
}

class Dynamic : public ::testing::TestWithParam<DynamicTree::Options> {};

TEST_P(Dynamic, FollowsWhatMovesFrameByFrame)
{
    Boxes scene = random_boxes(3000, 22, 0.3, 13, {5, -3, 1e3});
    DynamicTree tree = tree_of(scene, GetParam());
    EXPECT_EQ(find(tree, scene), scene.truth(GetParam().margin));
    for (std::uint64_t frame = 0; frame < 40; ++frame) {
        // None, one, some, most; a little, and now and then to the other end of the world.
        const double share = std::array{0.0, 0.0004, 0.05, 0.2, 0.6}[frame % 5];
        Bodies moved;
        for (std::uint32_t body : scene.all) {
            if (scene.is_static[body] || u01(frame, body, 0) >= share) continue;
            moved.push_back(body);
            step(scene, body, random_step(frame, body, frame % 7 == 6 ? 60 : 0.4));
        }
        tree.move(moved);
        ASSERT_EQ(find(tree, scene), scene.truth(GetParam().margin)) << "frame " << frame << ", moved " << moved.size();
    }
}

/// Everybody drifts inside a fat box for a while; now and then enough jump for all boxes to be taken in again.
TEST_P(Dynamic, FollowsDriftBetweenJumps)
{
    Boxes scene = random_boxes(1200, 20, 0, 41, {0, 0, 0});
    DynamicTree tree = tree_of(scene, GetParam());
    for (std::uint64_t frame = 0; frame < 60; ++frame) {
        for (std::uint32_t body : scene.all) {
            step(scene, body, random_step(1, body, 0.08));
            if (frame % 5 == 3 && body % 8 == frame % 8) step(scene, body, random_step(frame, body, 30));
        }
        tree.move(scene.all);
        ASSERT_EQ(find(tree, scene), scene.truth(GetParam().margin)) << "frame " << frame;
    }
}

/// All changes at random, against brute force on who is there and who is awake.
TEST_P(Dynamic, FollowsBodiesThatComeGoMoveSleepAndWake)
{
    Boxes scene = random_boxes(1500, 18, 0.5, 23, {0, 0, 0});
    std::vector<std::uint8_t> there(scene.all.size(), 0);
    DynamicTree tree(GetParam());
    for (std::uint64_t frame = 0; frame < 60; ++frame) {
        const double share = std::array{0.3, 0.002, 0.03, 0.9}[frame % 4];
        Bodies come, come_asleep, gone, moved, asleep, awake;
        for (std::uint32_t body : scene.all) {
            const double dice = u01(frame + 100, body, 0) / share;
            if (dice >= 1) continue;
            if (!there[body])
                (scene.is_static[body] = dice < 0.4) ? come_asleep.push_back(body) : come.push_back(body);
            else if (dice < 0.25)
                gone.push_back(body);
            else if (dice < 0.6)
                moved.push_back(body), step(scene, body, random_step(frame, body, dice < 0.3 ? 40 : 0.5));
            else
                (scene.is_static[body] ^= 1) ? asleep.push_back(body) : awake.push_back(body);
        }
        tree.add(come), tree.add(come_asleep, true), tree.move(moved), tree.sleep(asleep), tree.wake(awake);
        tree.remove(gone);
        for (const Bodies& list : {come, come_asleep})
            for (std::uint32_t body : list) there[body] = 1;
        for (std::uint32_t body : gone) there[body] = 0;
        if (frame % 9 == 4 && !gone.empty()) { // gone and back before anyone asks
            tree.add(std::span(gone).first(1), scene.is_static[gone[0]] != 0);
            there[gone[0]] = 1;
        }
        if (frame % 6 == 5) { // a question between changes and their pairs
            std::vector<BoxHit> hits;
            tree.query(columns(scene), {}, hits);
            EXPECT_TRUE(hits.empty());
        }
        Pairs expected = scene.truth(GetParam().margin);
        std::erase_if(expected, [&](BodyPair p) { return !there[p.a] || !there[p.b]; });
        ASSERT_EQ(find(tree, scene), expected) << "frame " << frame;
        ASSERT_EQ(tree.size(), std::size_t(std::count(there.begin(), there.end(), 1)));
        ASSERT_EQ(find(tree, scene), expected) << "asked again, nothing changed";
    }
}

INSTANTIATE_TEST_SUITE_P(, Dynamic,
                         ::testing::Values(DynamicTree::Options{}, DynamicTree::Options{.margin = 0.3},
                                           DynamicTree::Options{.fat = 0.5},
                                           DynamicTree::Options{.margin = 0.1, .fat = 0.2, .threads = 3}),
                         [](const auto& param) { return "options" + std::to_string(param.index); });

TEST(DynamicTree, GivesTheSameOnManyThreads)
{
    Boxes scene = random_boxes(60000, 80, 0.4, 29, {0, 0, 0});
    DynamicTree one = tree_of(scene), many = tree_of(scene, {.threads = 5});
    EXPECT_EQ(find(one, scene), find(many, scene));
    Bodies moved;
    for (std::uint32_t body : scene.all)
        if (body % 5 == 0) moved.push_back(body), step(scene, body, random_step(1, body, 3));
    one.move(moved), many.move(moved);
    const Pairs pairs = find(one, scene);
    EXPECT_GT(pairs.size(), 10000u);
    EXPECT_EQ(pairs, find(many, scene));
    EXPECT_LT(one.bytes(), 120 * scene.boxes.size());
}

TEST(DynamicTree, AnswersQuestionsAboutBoxes)
{
    Boxes scene = random_boxes(4000, 25, 0.5, 31, {1e6, 0, -1e6});
    for (const double margin : {0.0, 0.7}) {
        DynamicTree tree = tree_of(scene, {.margin = margin, .fat = 0.2});
        std::vector<Aabb> asked;
        for (std::uint64_t k = 0; k < 200; ++k) {
            const Eigen::Vector3d at(1e6 + 30 * u01(9, k, 0), 30 * u01(9, k, 1), -1e6 + 30 * u01(9, k, 2));
            asked.emplace_back();
            asked.back().add(at), asked.back().add(Eigen::Vector3d(at.array() + u01(9, k, 3) * 3));
        }
        std::vector<BoxHit> hits, expected;
        for (std::uint32_t k = 0; k < asked.size(); ++k)
            for (std::uint32_t body : scene.all) {
                Aabb grown = asked[k];
                grown.min.array() -= margin, grown.max.array() += margin;
                if (grown.overlaps(scene.boxes[body])) expected.push_back({k, body});
            }
        tree.query(columns(scene), asked, hits);
        EXPECT_GT(hits.size(), 500u);
        EXPECT_EQ(hits, expected);
        EXPECT_EQ(find(tree, scene), scene.truth(margin)) << "a question forgets no pair";
    }
}

/// What is left is enough for every pair, whatever moves and wherever to.
TEST(Delimitation, LeavesEveryBodyOfAPair)
{
    Boxes scene = random_boxes(6000, 90, 0.985, 11, {0, 0, 0});
    DynamicTree tree = tree_of(scene, {.margin = 0.05});
    Bodies moving, left;
    for (std::uint32_t body : scene.all)
        if (!scene.is_static[body]) moving.push_back(body);
    for (int frame = 0; frame < 30; ++frame) {
        tree.move(moving);
        tree.delimit(columns(scene));
        tree.survivors(left);
        ASSERT_TRUE(std::is_sorted(left.begin(), left.end()));
        EXPECT_EQ(tree.bodies_left(), left.size());
        for (BodyPair pair : scene.truth(0.05))
            for (std::uint32_t body : {pair.a, pair.b})
                ASSERT_TRUE(std::binary_search(left.begin(), left.end(), body)) << "frame " << frame;
        if (frame < 3) {
            EXPECT_LT(left.size(), scene.boxes.size() * 3 / 4) << "regions are rejected";
        }
        // Level by level, what is not left was rejected once.
        std::uint64_t rejected = 0, regions = 1, survived = 1;
        for (const DelimitationLevel& level : tree.levels()) {
            EXPECT_LE(level.regions, 16 * survived);
            EXPECT_GE(level.volume_rejected, 0);
            EXPECT_LE(level.volume_rejected, 1);
            survived = level.regions - level.regions_rejected;
            rejected += level.bodies_rejected, regions += level.regions;
        }
        EXPECT_EQ(rejected + left.size(), scene.boxes.size());
        EXPECT_GT(regions, 20u);
        // All wander to one corner, and out of the space that was built.
        for (std::uint32_t body : moving) step(scene, body, {-1.5, -1.0, 0.3 * (body % 5)});
    }
}

TEST(Delimitation, RejectsForbiddenLayersAndAllWhenNothingMoves)
{
    Boxes scene;
    for (int i = 0; i < 600; ++i) scene.add({10.0 * i, 0, 0}, {10.0 * i + 1, 1, 1}, true, 1, i < 300 ? 1 : 3);
    scene.add({2000, 0, 0}, {2001, 1, 1}, false, 2, 1); // where it is, nobody collides with layer 2
    scene.add({5000, 0, 0}, {5001, 1, 1}, false, 2, 3);
    DynamicTree tree = tree_of(scene);
    tree.delimit(columns(scene));
    Bodies left;
    tree.survivors(left);
    EXPECT_FALSE(std::binary_search(left.begin(), left.end(), 200u));
    EXPECT_TRUE(std::binary_search(left.begin(), left.end(), 500u));
    EXPECT_EQ(find(tree, scene), (Pairs{{500, 601}}));
    tree.move({});
    tree.delimit(columns(scene));
    scene.layers[600] = 1; // and now they do
    tree.move(Bodies{600});
    EXPECT_EQ(find(tree, scene), (Pairs{{200, 600}, {500, 601}}));
    tree.sleep(Bodies{600, 601});
    EXPECT_TRUE(find(tree, scene).empty());
    tree.delimit(columns(scene));
    ASSERT_FALSE(tree.levels().empty());
    EXPECT_EQ(tree.bodies_left(), 0u);
}

TEST(DynamicTree, RefusesWhatMakesNoSense)
{
    Boxes scene = random_boxes(100, 10, 0.5, 3, {0, 0, 0});
    DynamicTree tree = tree_of(scene);
    const Pairs pairs = find(tree, scene);
    const auto message = [](auto&& work) -> std::string {
        try {
            work();
        } catch (const Error& error) {
            return error.what();
        }
        return "no error";
    };
    const auto names = [&](const char* what, auto&& work) {
        const std::string text = message(work);
        EXPECT_NE(text.find(what), std::string::npos) << text;
    };
    names("body 7", [&] { tree.add(Bodies{7}); });
    names("body 100", [&] { tree.move(Bodies{3, 100}); });
    names("body 4000000000", [&] { tree.remove(Bodies{4000000000u}); });
    names("margin", [&] { DynamicTree({.margin = -1}); });
    names("fat", [&] { DynamicTree({.fat = std::nan("")}); });
    names("threads", [&] { DynamicTree({.threads = 0}); });
    names("columns", [&] { tree.find_pairs({std::span(scene.boxes).first(99)}); });
    names("columns", [&] { tree.find_pairs({scene.boxes, scene.layers, {}}); });
    std::vector<BoxHit> hits;
    Aabb infinite;
    names("query 0", [&] { tree.query(columns(scene), std::span(&infinite, 1), hits); });

    const Aabb good = scene.boxes[9];
    scene.boxes[9].min.z() = std::nan("");
    tree.move(Bodies{9});
    names("body 9", [&] { find(tree, scene); });
    names("body 9", [&] { find(tree, scene); });
    scene.boxes[9] = good;
    EXPECT_EQ(find(tree, scene), pairs) << "nothing was lost";

    // New bodies and a bad box at once, where layers forbid pairs.
    Boxes more = random_boxes(900, 20, 0.5, 3, {0, 0, 0});
    DynamicTree grown;
    grown.add(std::span(more.all).first(800));
    grown.find_pairs(columns(more));
    grown.add(std::span(more.all).subspan(800));
    const Aabb kept = more.boxes[5];
    more.boxes[5].max.x() = std::nan("");
    grown.move(Bodies{5});
    names("body 5", [&] { find(grown, more); });
    more.boxes[5] = kept;
    std::fill(more.is_static.begin(), more.is_static.end(), 0); // all were added awake
    EXPECT_EQ(find(grown, more), more.truth(0));
}

TEST(DynamicTree, HandlesNoneOneAndAllGone)
{
    Boxes scene;
    DynamicTree tree;
    EXPECT_TRUE(find(tree, scene).empty());
    for (int i = 0; i < 3; ++i) scene.add({0, 0, 0}, {1, 1, 1});
    for (int round = 0; round < 3; ++round) {
        tree.add(Bodies{0});
        EXPECT_TRUE(find(tree, scene).empty());
        tree.add(Bodies{1, 2});
        EXPECT_EQ(find(tree, scene).size(), 3u);
        tree.remove(Bodies{0, 1, 2});
        EXPECT_TRUE(find(tree, scene).empty());
        EXPECT_EQ(tree.size(), 0u);
    }
}

} // namespace
} // namespace oncollide
