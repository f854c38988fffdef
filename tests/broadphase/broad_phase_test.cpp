// Broad phases find the pairs of brute force after any changes.
#include <cmath>
#include <limits>

#include <oncollide/base/numbers/random.hpp>

#include "count_allocations.hpp"
#include "every_broad_phase.hpp"

namespace oncollide::broad_phase_test {
namespace {

TEST_P(EveryBroadPhase, FindsAllPairsOfRandomBoxes)
{
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const Boxes scene =
            random_boxes(400 + 40 * static_cast<std::uint32_t>(seed), 12, seed % 3 * 0.4, seed, {0, 0, 0});
        EXPECT_EQ(find_in(scene), truth(scene)) << "seed " << seed;
    }
}

TEST_P(EveryBroadPhase, IsExactFarFromTheOrigin)
{
    const Boxes scene = random_boxes(600, 12, 0.2, 5, {1e6, -2e6, 1e8});
    EXPECT_EQ(find_in(scene), truth(scene));
}

TEST_P(EveryBroadPhase, HandlesNoneOneTwoAndAllGone)
{
    Boxes scene;
    const auto broad = make();
    EXPECT_TRUE(find(*broad, scene).empty());
    scene.add({0, 0, 0}, {1, 1, 1}), scene.add({1, 1, 1}, {2, 2, 2});
    for (int round = 0; round < 3; ++round) {
        broad->add(Bodies{0});
        EXPECT_TRUE(find(*broad, scene).empty());
        broad->add(Bodies{1});
        EXPECT_EQ(find(*broad, scene), (Pairs{{0, 1}})) << "touching boxes overlap";
        EXPECT_TRUE(broad->contains(1));
        broad->remove(Bodies{1, 0});
        EXPECT_TRUE(find(*broad, scene).empty());
        EXPECT_EQ(broad->size(), 0u);
        EXPECT_FALSE(broad->contains(1));
    }
}

TEST_P(EveryBroadPhase, HandlesIdenticalBoxesAndOneGiant)
{
    Boxes same;
    for (int i = 0; i < 300; ++i) same.add({0, 0, 0}, {1, 1, 1});
    EXPECT_EQ(find_in(same).size(), 300u * 299 / 2);

    Boxes giant = random_boxes(500, 40, 0, 3, {0, 0, 0});
    giant.add({-100, -100, -100}, {100, 100, 100});
    EXPECT_EQ(find_in(giant), truth(giant));
}

TEST_P(EveryBroadPhase, AgreesOnFlatAndClusteredAndStackedBoxes)
{
    Boxes scene;
    for (std::uint32_t i = 0; i < 3000; ++i) {
        const Eigen::Vector3d centre(60 * u01(8, i, 0), i % 3 == 0 ? 1e-3 * u01(8, i, 1) : 60, i % 3 == 1 ? 5 : 0);
        const double half = i % 3 == 2 ? 1e-7 : 0.4;
        scene.add(centre.array() - half, centre.array() + half);
    }
    EXPECT_EQ(find_in(scene), truth(scene));
}

TEST_P(EveryBroadPhase, FindsThePairsOfBoxesOfEverySizeTogether)
{
    Boxes scene;
    for (std::uint32_t i = 0; i < 4000; ++i) {
        const double half = std::pow(10.0, -3 + 4.5 * std::pow(u01(3, i, 0), 4)); // 1 mm to 30 m, mostly small
        const Eigen::Vector3d at(40 * u01(3, i, 1), 40 * u01(3, i, 2), i % 3 ? 40 * u01(3, i, 3) : 0);
        scene.add(at.array() - half, at.array() + half);
    }
    const Pairs pairs = find_in(scene);
    EXPECT_GT(pairs.size(), 1000u);
    EXPECT_EQ(pairs, truth(scene));
}

TEST_P(EveryBroadPhase, FormsNoPairsOfStaticBodiesOrAgainstLayersMasksAndGroups)
{
    Boxes scene;
    const auto add = [&](bool is_static, std::uint32_t layer, std::uint32_t mask, std::uint32_t group) {
        scene.add({0, 0, 0}, {1, 1, 1}, is_static, layer, mask, group);
    };
    add(true, 1, ~0u, 0), add(true, 1, ~0u, 0), add(false, 2, 1, 0), add(false, 1, 1, 0);
    EXPECT_EQ(find_in(scene), (Pairs{{0, 2}, {0, 3}, {1, 2}, {1, 3}})) << "2 and 3: 3 does not collide with layer 2";
    add(false, 1, 1, 7), add(false, 1, 1, 7);
    EXPECT_EQ(find_in(scene), (Pairs{{0, 2}, {0, 3}, {0, 4}, {0, 5}, {1, 2}, {1, 3}, {1, 4}, {1, 5}, {3, 4}, {3, 5}}));
    const auto broad = make();
    scene.add_to(*broad);
    EXPECT_EQ(find(*broad, scene).size(), 10u);
    scene.groups[5] = 8, scene.layers[2] = 0;
    broad->move(Bodies{2, 5});
    EXPECT_EQ(find(*broad, scene), (Pairs{{0, 3}, {0, 4}, {0, 5}, {1, 3}, {1, 4}, {1, 5}, {3, 4}, {3, 5}, {4, 5}}));
    const auto pairs = broad->find_pairs({.boxes = scene.boxes}, true);
    EXPECT_EQ(pairs.size(), 14u) << "all pairs except the pair of static bodies";
}

TEST_P(EveryBroadPhase, FollowsWhatMovesFrameByFrame)
{
    Boxes scene = random_boxes(3000, 22, 0.3, 13, {5, -3, 1e3});
    const auto broad = make();
    scene.add_to(*broad);
    EXPECT_EQ(find(*broad, scene), truth(scene));
    for (std::uint64_t frame = 0; frame < 40; ++frame) {
        // Moves none, one, some or most; by a little, and sometimes across the world.
        const double share = std::array{0.0, 0.0004, 0.05, 0.2, 0.6}[frame % 5];
        Bodies moved;
        for (std::uint32_t body : scene.all) {
            if (scene.is_static[body] || u01(frame, body, 0) >= share) continue;
            moved.push_back(body);
            scene.step(body, random_step(frame, body, frame % 7 == 6 ? 60 : 0.4));
        }
        broad->move(moved);
        ASSERT_EQ(find(*broad, scene, frame % 11 == 10), truth(scene)) << "frame " << frame << ": " << moved.size();
    }
}

/// Jumps give bodies new leaves. In every eighth frame so many move that the whole tree is searched for their pairs.
TEST_P(EveryBroadPhase, FollowsBodiesThatJumpAmongBodiesAtRest)
{
    Boxes scene = random_boxes(1200, 16, 0.3, 17, {0, 2, 0});
    const auto broad = make();
    scene.add_to(*broad);
    EXPECT_EQ(find(*broad, scene), truth(scene));
    for (std::uint64_t frame = 0; frame < 40; ++frame) {
        Bodies moved;
        for (std::uint32_t body : scene.all) {
            if (scene.is_static[body] || u01(frame, body, 0) >= (frame % 8 == 7 ? 0.5 : 0.02)) continue;
            moved.push_back(body);
            scene.step(body, random_step(frame, body, 40));
        }
        broad->move(moved);
        ASSERT_EQ(find(*broad, scene), truth(scene)) << "frame " << frame << ": " << moved.size();
    }
}

/// All changes at random, in bulk.
TEST_P(EveryBroadPhase, FollowsBodiesThatComeGoMoveBecomeStaticAndChangeLayersAndGroups)
{
    Boxes scene = random_boxes(1500, 18, 0.5, 23, {0, 0, 0});
    std::vector<std::uint8_t> there(scene.all.size(), 0);
    const auto broad = make();
    for (std::uint64_t frame = 0; frame < 80; ++frame) {
        const double share = std::array{0.3, 0.002, 0.03, 0.9}[frame % 4];
        Bodies come, come_static, gone, moved, is_static, dynamic;
        for (std::uint32_t body : scene.all) {
            const double dice = u01(frame + 100, body, 0) / share;
            if (dice >= 1) continue;
            if (!there[body]) {
                (scene.is_static[body] = dice < 0.4) ? come_static.push_back(body) : come.push_back(body);
            } else if (dice < 0.25) {
                gone.push_back(body);
            } else if (dice < 0.6) {
                moved.push_back(body), scene.step(body, random_step(frame, body, dice < 0.3 ? 40 : 0.5));
                if (dice > 0.5) scene.layers[body] = 1u << (frame % 4);
                if (dice > 0.55) scene.groups[body] = static_cast<std::uint32_t>(frame % 3), scene.masks[body] ^= 4;
            } else {
                (scene.is_static[body] ^= 1) ? is_static.push_back(body) : dynamic.push_back(body);
            }
        }
        broad->add(come), broad->add(come_static, true), broad->move(moved), broad->make_static(is_static),
            broad->make_dynamic(dynamic);
        broad->remove(gone);
        for (const Bodies& list : {come, come_static})
            for (std::uint32_t body : list) there[body] = 1;
        for (std::uint32_t body : gone) there[body] = 0;
        if (frame % 9 == 4 && !gone.empty()) { // removed and added again before the next query
            broad->add(std::span(gone).first(1), scene.is_static[gone[0]] != 0);
            there[gone[0]] = 1;
        }
        if (frame % 3 == 1) broad->take_in(scene.columns());
        if (frame % 6 == 5) broad->delimit(scene.columns());
        Pairs expected = truth(scene);
        std::erase_if(expected, [&](BodyPair p) { return !there[p.a] || !there[p.b]; });
        ASSERT_EQ(find(*broad, scene, frame % 10 == 9), expected) << "frame " << frame;
        ASSERT_EQ(broad->size(), std::size_t(std::count(there.begin(), there.end(), 1)));
        ASSERT_EQ(find(*broad, scene), expected) << "nothing changed";
    }
}

/// Most stay within the enlarged boxes of the trees, while other changes happen.
TEST_P(EveryBroadPhase, FollowsBodiesThatDriftSlowlyAmongOtherChanges)
{
    Boxes scene = random_boxes(1600, 19, 0.5, 41, {-7, 1e3, 0});
    const auto broad = make();
    scene.add_to(*broad);
    std::vector<std::uint8_t> there(scene.all.size(), 1);
    Bodies left;
    for (std::uint64_t frame = 0; frame < 70; ++frame) {
        Bodies drifting, changed;
        for (std::uint32_t body : scene.all)
            if (there[body] && body % 8 == 3) drifting.push_back(body);
        const auto drift = [&](double frames) {
            for (std::uint32_t body : drifting) // some fast; all reverse from time to time
                scene.step(body, random_step(frame / 20, body, body % 5 ? 0.06 : 0.5) * frames);
            broad->move(drifting);
        };
        drift(0.5);
        if (frame % 5 == 4) broad->take_in(scene.columns());
        drift(0.5);
        for (std::uint32_t body : scene.all) {
            const double dice = u01(frame + 300, body, 0) / 0.01;
            if (dice >= 1) continue;
            const Bodies one{body};
            if (!there[body]) {
                broad->add(one, scene.is_static[body] != 0), there[body] = 1;
            } else if (dice < 0.2) {
                broad->remove(one), there[body] = 0;
            } else if (dice < 0.6) {
                (scene.is_static[body] ^= 1) ? broad->make_static(one) : broad->make_dynamic(one);
            } else {
                (dice < 0.8 ? scene.layers[body] : scene.groups[body]) ^= 1, broad->move(one);
            }
            changed.push_back(body);
        }
        Pairs expected = truth(scene);
        std::erase_if(expected, [&](BodyPair p) { return !there[p.a] || !there[p.b]; });
        if (frame % 4 == 1) {
            changed.insert(changed.end(), drifting.begin(), drifting.end());
            std::ranges::sort(changed);
            broad->delimit(scene.columns());
            broad->survivors(left);
            const auto is_in = [](const Bodies& list, std::uint32_t body) {
                return std::ranges::binary_search(list, body);
            };
            for (const auto [a, b] : expected) {
                const bool told = is_in(left, a) && is_in(left, b);
                ASSERT_TRUE(told || !(is_in(changed, a) || is_in(changed, b))) << a << ' ' << b;
            }
        }
        if (frame % 4 == 3) continue; // no query
        ASSERT_EQ(find(*broad, scene, frame % 13 == 12), expected) << "frame " << frame;
    }
}

/// Clusters of one group or of no group, whose bodies also change groups: whole regions of the trees are of one group.
TEST_P(EveryBroadPhase, FindsPairsBetweenGroupsThatFillRegions)
{
    Boxes scene = random_boxes(1600, 16, 0.2, 43, {1, 2, 3});
    for (std::uint32_t body : scene.all) {
        const Eigen::Vector3d at = scene.boxes[body].centre();
        scene.groups[body] = at.x() < 6 ? 0 : at.x() < 10 ? 4 : at.y() < 9 ? 0xffffffffu : 5;
        scene.layers[body] = 1, scene.masks[body] = ~0u;
    }
    const auto broad = make();
    scene.add_to(*broad);
    for (std::uint64_t frame = 0; frame < 24; ++frame) {
        Bodies changed;
        for (std::uint32_t body : scene.all) {
            const double dice = u01(frame + 700, body, 0);
            if (frame > 0 && dice > (frame % 6 ? 0.02 : 0.6)) continue;
            if (dice < 0.002) scene.groups[body] = frame % 3 ? 4 : 0;
            if (!scene.is_static[body]) scene.step(body, random_step(frame, body, dice < 0.001 ? 20 : 0.5));
            changed.push_back(body);
        }
        broad->move(changed);
        ASSERT_EQ(find(*broad, scene), truth(scene)) << "frame " << frame;
    }
}

/// A body whose layers or group forbid all pairs with its neighbours has pairs farther away.
TEST_P(EveryBroadPhase, TellsOfAChangedBodyAmongOthersThatItCannotMeet)
{
    for (const bool by_group : {false, true}) {
        Boxes scene;
        for (std::uint32_t i = 0; i < 2000; ++i) // a long row
            scene.add({double(i), 0, 0}, {i + 1.5, 1, 1}, false, 1, by_group ? ~0u : 2, by_group ? 7 : 0);
        scene.add({0.2, 0.2, 0.2}, {1999, 0.3, 0.3}, false, by_group ? 1 : 2, by_group ? ~0u : 1); // along all of it
        const auto broad = make();
        scene.add_to(*broad);
        ASSERT_EQ(find(*broad, scene).size(), 2000u);
        scene.step(500, {0.25, 0, 0});
        broad->move(Bodies{500});
        broad->delimit(scene.columns());
        Bodies left;
        broad->survivors(left);
        EXPECT_TRUE(std::ranges::binary_search(left, 500u));
        EXPECT_TRUE(std::ranges::binary_search(left, 2000u));
    }
}

/// The columns get groups after the only body is gone whose layers forbade pairs.
TEST_P(EveryBroadPhase, FindsPairsOfNewBodiesOnceLayersForbidNoMore)
{
    Boxes scene = random_boxes(600, 10, 0, 47, {0, 0, 0});
    scene.layers.assign(600, 1), scene.masks.assign(600, ~0u), scene.groups.assign(600, 0);
    scene.layers[0] = 2, scene.masks[0] = 4;
    const auto broad = make();
    const auto columns = [&](bool groups) {
        return BodyColumns{scene.boxes, scene.layers, scene.masks,
                           groups ? std::span<const std::uint32_t>(scene.groups) : std::span<const std::uint32_t>()};
    };
    broad->add(std::span(scene.all).first(550));
    broad->find_pairs(columns(false));
    broad->remove(Bodies{0});
    broad->find_pairs(columns(false));
    scene.groups[7] = 5, scene.layers[599] = 8; // which no other body is on
    broad->add(std::span(scene.all).last(50));
    const auto found = broad->find_pairs(columns(true));
    Pairs expected = truth(scene);
    std::erase_if(expected, [](BodyPair p) { return p.a == 0; });
    EXPECT_EQ(Pairs(found.begin(), found.end()), expected);
}

/// The pairs that layers, groups or static bodies forbid must take no memory in a heap of boxes.
TEST_P(EveryBroadPhase, HoldsNoForbiddenPairsOfAHeap)
{
    constexpr std::uint32_t count = 3000;
    Boxes by_layer, by_group, by_static;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Eigen::Vector3d low = 0.01 * Eigen::Vector3d(u01(1, i, 0), u01(1, i, 1), u01(1, i, 2)), high(1, 1, 1);
        // The layers of each body meet the mask of the other half, whose layers do not meet its mask.
        by_layer.add(low, high, false, i % 2 ? 1 : 4, i % 2 ? 2 : 1);
        by_group.add(low, high, false, 1, 1, 5);
        by_static.add(low, high, i > 0);
    }
    for (Boxes* scene : {&by_layer, &by_group, &by_static}) {
        const auto broad = make();
        scene->add_to(*broad);
        const Pairs expected = truth(*scene);
        EXPECT_EQ(expected.size(), scene == &by_static ? count - 1 : 0);
        EXPECT_EQ(find(*broad, *scene), expected);
        for (const std::uint32_t moved : {1u, 100u, count / 5, count / 2, count}) {
            broad->move(std::span(scene->all).first(moved));
            EXPECT_EQ(find(*broad, *scene), expected) << moved;
        }
        EXPECT_LT(broad->bytes(), 1000 * count) << "storing all pairs would take at least 36 MB";
    }
}

/// Most queries reach most regions here.
TEST_P(EveryBroadPhase, FindsTheFewPairsAllowedInAHeap)
{
    Boxes scene;
    for (std::uint32_t i = 0; i < 6000; ++i) scene.add({0, 0, 0}, {1, 1, 1}, false, i % 1000 ? 1 : 2, i % 1000 ? 2 : 1);
    const auto broad = make();
    scene.add_to(*broad);
    const Pairs expected = find(*broad, scene);
    EXPECT_EQ(expected.size(), 6u * 5994);
    Bodies left;
    for (const std::uint32_t moved : {3u, 1400u}) {
        broad->move(std::span(scene.all).first(moved));
        broad->delimit(scene.columns());
        broad->survivors(left);
        EXPECT_EQ(left.size(), broad->bodies_left());
        EXPECT_EQ(left, scene.all);
        EXPECT_EQ(find(*broad, scene), expected);
    }
}

class BroadPhaseOfOneThread : public EveryBroadPhase {};

TEST_P(BroadPhaseOfOneThread, AllocatesNothingInAWarmFrame)
{
    Boxes scene = random_boxes(2000, 22, 0.3, 43, {0, 0, 0});
    const auto broad = make();
    scene.add_to(*broad);
    std::vector<AabbHit> hits;
    for (std::uint64_t frame = 0; frame < 24; ++frame) {
        Bodies moved;
        for (std::uint32_t body : scene.all)
            if (body % (frame % 2 ? 50u : 2u) == 0) moved.push_back(body);
        for (std::uint32_t body : moved) scene.step(body, {frame % 4 < 2 ? 0.1 : -0.1, 0, 0});
        const std::size_t before = allocations;
        broad->move(moved);
        broad->find_pairs(scene.columns());
        broad->query(scene.columns(), std::span(scene.boxes).first(20), hits);
        if (frame >= 8) {
            EXPECT_EQ(allocations - before, 0u) << "frame " << frame;
        }
    }
}

const BroadPhase::Options plain, grown{.margin = 0.3}, threaded{.margin = 0.1, .threads = 3};
const auto name_of = [](const auto& param) { return param.param.name; };
INSTANTIATE_TEST_SUITE_P(
    , EveryBroadPhase,
    ::testing::Values(Algorithm{"kd", make_kd_tree, plain}, Algorithm{"kd_margin", make_kd_tree, grown},
                      Algorithm{"kd_threads", make_kd_tree, threaded}, Algorithm{"octree", make_octree, plain},
                      Algorithm{"octree_threads", make_octree, threaded}, Algorithm{"brute", make_brute_force, plain},
                      Algorithm{"brute_margin", make_brute_force, grown}),
    name_of);
INSTANTIATE_TEST_SUITE_P(, BroadPhaseOfOneThread,
                         ::testing::Values(Algorithm{"kd", make_kd_tree, plain},
                                           Algorithm{"kd_margin", make_kd_tree, grown},
                                           Algorithm{"octree", make_octree, plain},
                                           Algorithm{"brute", make_brute_force, plain},
                                           Algorithm{"brute_margin", make_brute_force, grown}),
                         name_of);

} // namespace
} // namespace oncollide::broad_phase_test
