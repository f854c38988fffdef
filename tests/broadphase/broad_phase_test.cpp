#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/random.hpp>

#include "boxes.hpp"
#include "count_allocations.hpp"

namespace oncollide {
namespace {

struct Algorithm {
    const char* name;
    std::unique_ptr<BroadPhase> (*make)(const BroadPhase::Options&);
    BroadPhase::Options options;
};

std::string message_of(auto&& work)
{
    try {
        work();
    } catch (const Error& error) {
        return error.what();
    }
    return "no error";
}

class EveryBroadPhase : public ::testing::TestWithParam<Algorithm> {
protected:
    std::unique_ptr<BroadPhase> make() const { return GetParam().make(GetParam().options); }
    /// The pairs of a new broad phase for this scene.
    Pairs find_in(const Boxes& scene) const { return find_anew(make(), scene); }
    Pairs truth(const Boxes& scene) const { return scene.truth(margin_); }
    const double margin_ = GetParam().options.margin;
};

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

TEST_P(EveryBroadPhase, AnswersQueriesFromManyThreadsAtOnce)
{
    Boxes scene = random_boxes(4000, 25, 0.5, 31, {1e6, 0, -1e6});
    const auto broad = make();
    scene.add_to(*broad);
    broad->remove(Bodies{17});
    std::vector<Aabb> boxes;
    for (std::uint64_t k = 0; k < 200; ++k) {
        const Eigen::Vector3d at(1e6 + 30 * u01(9, k, 0), 30 * u01(9, k, 1), -1e6 + 30 * u01(9, k, 2));
        boxes.emplace_back();
        boxes.back().add(at), boxes.back().add(Eigen::Vector3d(at.array() + u01(9, k, 3) * 3));
    }
    std::vector<AabbHit> expected;
    for (std::uint32_t k = 0; k < boxes.size(); ++k)
        for (std::uint32_t body : scene.all) {
            Aabb grown = boxes[k];
            grown.min.array() -= margin_, grown.max.array() += margin_;
            if (body != 17 && grown.overlaps(scene.boxes[body])) expected.push_back({k, body});
        }
    EXPECT_GT(expected.size(), 500u);
    broad->take_in(scene.columns());
    constexpr std::size_t threads = 4;
    std::array<std::vector<AabbHit>, threads> hits;
    std::vector<std::thread> running;
    for (std::vector<AabbHit>& mine : hits)
        running.emplace_back([&] {
            for (int round = 0; round < 20; ++round) broad->query(scene.columns(), boxes, mine);
        });
    for (std::thread& thread : running) thread.join();
    for (const std::vector<AabbHit>& mine : hits) EXPECT_EQ(mine, expected);
    Pairs pairs = truth(scene);
    std::erase_if(pairs, [](BodyPair p) { return p.a == 17 || p.b == 17; });
    EXPECT_EQ(find(*broad, scene), pairs) << "a query forgets no pair";
    broad->query(scene.columns(), {}, hits[0]);
    EXPECT_TRUE(hits[0].empty());
}

/// The fractions at which a segment enters and leaves a box overlap, with an allowance for rounding.
bool crosses(const Segment& s, const Aabb& box, double allowance)
{
    double begin = 0, end = 1;
    for (int k = 0; k < 3; ++k) {
        const long double from = s.from[k], along = static_cast<long double>(s.to[k]) - from;
        const long double low = box.min[k] - allowance - from, high = box.max[k] + allowance - from;
        if (along == 0) {
            if (low > 0 || high < 0) return false;
            continue;
        }
        begin = std::max(begin, static_cast<double>(std::min(low / along, high / along)));
        end = std::min(end, static_cast<double>(std::max(low / along, high / along)));
    }
    return begin <= end;
}

TEST_P(EveryBroadPhase, FindsAllBoxesThatASegmentMeets)
{
    for (const double far : {0.0, 1e6, 1e25}) {
        Boxes scene = random_boxes(1500, 18, 0.5, 31, {far, 0, -far});
        if (far > 1e9) // smaller boxes would be points
            for (Aabb& box : scene.boxes) box.max += 0.01 * far * Eigen::Vector3d(1, 2, 3);
        const auto broad = make();
        scene.add_to(*broad);
        broad->remove(Bodies{17});
        find(*broad, scene);
        Bodies moved;
        for (std::uint32_t body = 0; body < 300; ++body) moved.push_back(20 + body), scene.step(20 + body, {3, -2, 1});
        broad->move(moved);
        std::vector<Segment> segments;
        const auto at = [&](std::uint64_t k, std::uint64_t c, double reach) {
            return Eigen::Vector3d(far + reach * u01(k, c, 0), reach * u01(k, c, 1), -far + reach * u01(k, c, 2));
        };
        for (std::uint64_t k = 0; k < 80; ++k) {
            const Eigen::Vector3d from = at(k, 5, 30), corner = scene.boxes[k].max;
            segments.push_back({from, at(k, 6, 30)});
            segments.push_back({from, from});
            segments.push_back({corner, corner + Eigen::Vector3d(k % 2 ? 40 : -40, 0, 0)});
            segments.push_back({corner + Eigen::Vector3d(1, -1, 0), corner + Eigen::Vector3d(-1, 1, 0)});
            segments.push_back({from - 1e7 * (from - at(k, 7, 30)), from});
        }
        std::vector<AabbHit> hits;
        broad->take_in(scene.columns());
        broad->query_segments(scene.columns(), segments, hits);
        EXPECT_TRUE(std::ranges::is_sorted(hits));
        std::size_t found = 0, needed = 0;
        for (std::uint32_t k = 0; k < segments.size(); ++k) {
            const double largest = std::max(segments[k].from.cwiseAbs().maxCoeff(), 2 * far);
            for (std::uint32_t body : scene.all) {
                Aabb grown = scene.boxes[body];
                grown.min.array() -= margin_, grown.max.array() += margin_;
                const bool there = found < hits.size() && hits[found] == AabbHit{k, body};
                found += there;
                if (body == 17) {
                    EXPECT_FALSE(there);
                } else if (crosses(segments[k], grown, 0)) {
                    EXPECT_TRUE(there) << far << " " << k << " " << body;
                    ++needed;
                } else if (there) {
                    EXPECT_TRUE(crosses(segments[k], grown, 0x1p-40 * largest)) << far << " " << k << " " << body;
                }
            }
        }
        EXPECT_EQ(found, hits.size());
        EXPECT_GT(needed, 500u);
    }
}

/// One thread: the share of each of several threads, and so its memory, is not deterministic.
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

TEST_P(EveryBroadPhase, RefusesWhatMakesNoSense)
{
    Boxes scene = random_boxes(300, 10, 0.5, 3, {0, 0, 0});
    const auto broad = make();
    scene.add_to(*broad);
    const Pairs pairs = find(*broad, scene);
    const auto names = [&](const char* what, auto&& work) {
        const std::string text = message_of(work);
        EXPECT_NE(text.find(what), std::string::npos) << text;
    };
    names("body 7", [&] { broad->add(Bodies{7}); });
    names("body 300", [&] { broad->move(Bodies{3, 300}); });
    names("body 4000000000", [&] { broad->remove(Bodies{4000000000u}); });
    names("body 301", [&] { broad->make_static(Bodies{301}); });
    names("body 302", [&] { broad->make_dynamic(Bodies{302}); });
    names("margin", [&] { GetParam().make({.margin = -1}); });
    names("margin", [&] { GetParam().make({.margin = std::nan("")}); });
    names("threads", [&] { GetParam().make({.threads = 0}); });
    names("columns", [&] { broad->find_pairs({std::span(scene.boxes).first(299)}); });
    names("columns", [&] { broad->find_pairs({scene.boxes, scene.layers, {}}); });
    names("columns", [&] { broad->find_pairs({.boxes = scene.boxes, .groups = std::span(scene.groups).first(9)}); });
    std::vector<AabbHit> hits;
    const Aabb empty;
    names("query 0", [&] { broad->query(scene.columns(), std::span(&empty, 1), hits); });
    const Segment bad{{0, 0, 0}, {0, std::nan(""), 0}};
    names("query 0", [&] { broad->query_segments(scene.columns(), std::span(&bad, 1), hits); });
    broad->move(Bodies{3});
    names("take_in", [&] { broad->query(scene.columns(), std::span(scene.boxes).first(1), hits); });
    EXPECT_EQ(find(*broad, scene), pairs) << "nothing was lost";
}

TEST_P(EveryBroadPhase, RefusesBoxesThatAreNotFiniteNamesTheBodyAndLosesNothing)
{
    const double infinity = std::numeric_limits<double>::infinity();
    for (const std::uint32_t first : {0u, 100u, 250u}) // all bodies new, some, few
        for (const double bad : {infinity, -infinity, std::nan(""), 1e31}) {
            Boxes scene = random_boxes(300, 12, 0, 1, {0, 0, 0});
            const auto broad = make();
            broad->add(std::span(scene.all).first(first));
            broad->take_in(scene.columns());
            broad->add(std::span(scene.all).subspan(first));
            if (first > 50) broad->move(Bodies{50});
            for (const std::uint32_t body : {50u, 280u}) {
                const double good = scene.boxes[body].max.y();
                scene.boxes[body].max.y() = bad;
                for (int round = 0; round < 2; ++round) {
                    const std::string text = message_of([&] { find(*broad, scene); });
                    EXPECT_NE(text.find("body " + std::to_string(body)), std::string::npos) << text;
                }
                scene.boxes[body].max.y() = good;
            }
            EXPECT_EQ(find(*broad, scene), truth(scene));
            scene.boxes[123].max.y() = 1e29;
            broad->move(Bodies{123});
            EXPECT_EQ(find(*broad, scene), truth(scene));
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
} // namespace oncollide
