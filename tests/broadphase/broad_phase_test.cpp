#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/broad_phase.hpp>

#include "boxes.hpp"

namespace oncollide {
namespace {

struct Algorithm {
    const char* name;
    std::unique_ptr<BroadPhase> (*make)();
};

class EveryBroadPhase : public ::testing::TestWithParam<Algorithm> {
protected:
    std::vector<BodyPair> find(const Boxes& scene, double margin = 0, int threads = 1)
    {
        std::vector<BodyPair> pairs{{7, 7}};
        algorithm_->find_pairs(scene.boxes, scene.all, scene.filter(), margin, threads, pairs);
        return pairs;
    }
    std::unique_ptr<BroadPhase> algorithm_ = GetParam().make();
};

TEST_P(EveryBroadPhase, FindsThePairsOfBruteForceOnRandomBoxes)
{
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const Boxes scene =
            random_boxes(400 + 40 * static_cast<std::uint32_t>(seed), 12, seed % 3 * 0.4, seed, {0, 0, 0});
        EXPECT_EQ(find(scene, seed % 2 * 0.1), scene.truth(seed % 2 * 0.1)) << "seed " << seed;
    }
}

TEST_P(EveryBroadPhase, IsExactFarFromTheOrigin)
{
    const Boxes scene = random_boxes(600, 12, 0.2, 5, {1e6, -2e6, 1e8});
    EXPECT_EQ(find(scene), scene.truth(0));
}

TEST_P(EveryBroadPhase, GivesTheSameListForAnyThreadCount)
{
    const Boxes scene = random_boxes(20000, 40, 0.3, 9, {0, 0, 0});
    const auto one = find(scene, 0, 1);
    EXPECT_GT(one.size(), 1000u);
    EXPECT_EQ(find(scene, 0, 2), one);
    EXPECT_EQ(find(scene, 0, 5), one);
}

TEST_P(EveryBroadPhase, HandlesNoneOneAndTwoBodies)
{
    Boxes scene;
    EXPECT_TRUE(find(scene).empty());
    scene.add({0, 0, 0}, {1, 1, 1});
    EXPECT_TRUE(find(scene).empty());
    scene.add({1, 1, 1}, {2, 2, 2});
    EXPECT_EQ(find(scene), (std::vector<BodyPair>{{0, 1}})) << "touching boxes overlap";
}

TEST_P(EveryBroadPhase, HandlesIdenticalBoxesAndOneGiant)
{
    Boxes same;
    for (int i = 0; i < 300; ++i) same.add({0, 0, 0}, {1, 1, 1});
    EXPECT_EQ(find(same).size(), 300u * 299 / 2);

    Boxes giant = random_boxes(500, 40, 0, 3, {0, 0, 0});
    giant.add({-100, -100, -100}, {100, 100, 100});
    EXPECT_EQ(find(giant), giant.truth(0));
}

TEST_P(EveryBroadPhase, FormsNoStaticPairsAndRespectsLayers)
{
    Boxes scene;
    scene.add({0, 0, 0}, {1, 1, 1}, true);
    scene.add({0, 0, 0}, {1, 1, 1}, true);
    scene.add({0, 0, 0}, {1, 1, 1}, false, 2, 1);
    scene.add({0, 0, 0}, {1, 1, 1}, false, 1, 1);
    EXPECT_EQ(find(scene), (std::vector<BodyPair>{{0, 2}, {0, 3}, {1, 2}, {1, 3}}))
        << "2 and 3: 3 does not collide with layer 2";
}

TEST_P(EveryBroadPhase, RefusesBoxesThatAreNotFiniteAndNamesTheBody)
{
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double bad : {infinity, -infinity, std::nan(""), 1e31}) {
        Boxes scene = random_boxes(300, 12, 0, 1, {0, 0, 0});
        EXPECT_FALSE(find(scene).empty());
        scene.boxes[123].max.y() = bad;
        try {
            find(scene);
            ADD_FAILURE() << bad;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("body 123"), std::string::npos) << error.what();
        }
        scene.boxes[123].max.y() = 1e29;
        EXPECT_EQ(find(scene), scene.truth(0));
    }
}

TEST_P(EveryBroadPhase, FindsAllAfterItRefusedAnotherSetOfBodies)
{
    Boxes scene = random_boxes(300, 8, 0, 1, {0, 0, 0});
    std::vector<BodyPair> pairs;
    const auto half = std::span(scene.all).first(150);
    algorithm_->find_pairs(scene.boxes, half, scene.filter(), 0, 1, pairs);
    const Aabb good = scene.boxes[200];
    scene.boxes[200].min.x() = std::nan("");
    EXPECT_THROW(find(scene), Error);
    scene.boxes[200] = good;
    EXPECT_EQ(find(scene), scene.truth(0));
}

TEST_P(EveryBroadPhase, AgreesOnFlatAndClusteredAndStackedBoxes)
{
    Boxes scene;
    for (std::uint32_t i = 0; i < 3000; ++i) {
        const Eigen::Vector3d centre(60 * u01(8, i, 0), i % 3 == 0 ? 1e-3 * u01(8, i, 1) : 60, i % 3 == 1 ? 5 : 0);
        const double half = i % 3 == 2 ? 1e-7 : 0.4;
        scene.add(centre.array() - half, centre.array() + half);
    }
    EXPECT_EQ(find(scene), scene.truth(0));
}

INSTANTIATE_TEST_SUITE_P(, EveryBroadPhase,
                         ::testing::Values(Algorithm{"kd", make_kd_tree}, Algorithm{"octree", make_octree},
                                           Algorithm{"brute", make_brute_force}),
                         [](const auto& param) { return param.param.name; });

TEST(KdTree, TakesOtherBodiesAndOtherStaticsFromCallToCall)
{
    Boxes scene = random_boxes(1200, 15, 0.2, 17, {0, 0, 0});
    const auto kd = make_kd_tree(), brute = make_brute_force();
    std::vector<BodyPair> pairs, expected;
    for (std::uint32_t call = 0; call < 6; ++call) {
        std::vector<std::uint32_t> bodies;
        for (std::uint32_t body : scene.all) {
            if ((body + call) % 4) bodies.push_back(body);
            if (call % 2) scene.is_static[body] = u01(call, body, 9) < 0.5;
        }
        kd->find_pairs(scene.boxes, call % 3 == 2 ? scene.all : bodies, scene.filter(), 0.1 * call, 1, pairs);
        brute->find_pairs(scene.boxes, call % 3 == 2 ? scene.all : bodies, scene.filter(), 0.1 * call, 1, expected);
        EXPECT_EQ(pairs, expected) << "call " << call;
    }
}

TEST(KdTree, FindsThePairsOfBoxesOfEverySizeTogether)
{
    Boxes scene;
    for (std::uint32_t i = 0; i < 4000; ++i) {
        const double half = std::pow(10.0, -3 + 4.5 * std::pow(u01(3, i, 0), 4)); // 1 mm to 30 m, mostly small
        const Eigen::Vector3d at(40 * u01(3, i, 1), 40 * u01(3, i, 2), i % 3 ? 40 * u01(3, i, 3) : 0);
        scene.add(at.array() - half, at.array() + half);
    }
    std::vector<BodyPair> pairs, expected;
    make_kd_tree()->find_pairs(scene.boxes, scene.all, scene.filter(), 0, 1, pairs);
    make_brute_force()->find_pairs(scene.boxes, scene.all, scene.filter(), 0, 1, expected);
    EXPECT_GT(expected.size(), 1000u);
    EXPECT_EQ(pairs, expected);
}

TEST(KdTree, CountsATouchingGridAndAGiantFarFromTheOrigin)
{
    constexpr int side = 30;
    Boxes scene;
    const Eigen::Vector3d at(1e8, -1e8, 3e7);
    for (int x = 0; x < side; ++x)
        for (int y = 0; y < side; ++y)
            for (int z = 0; z < side; ++z) {
                const Eigen::Vector3d corner = at + Eigen::Vector3d(x, y, z);
                scene.add(corner, corner.array() + 1);
            }
    // Each box touches the 26 around it: (3 side - 2)^3 ordered pairs of neighbours, themselves included.
    constexpr std::size_t boxes = side * side * side,
                          neighbours = std::size_t{3 * side - 2} * (3 * side - 2) * (3 * side - 2);
    std::vector<BodyPair> pairs;
    const auto kd = make_kd_tree();
    kd->find_pairs(scene.boxes, scene.all, scene.filter(), 0, 1, pairs);
    EXPECT_EQ(pairs.size(), (neighbours - boxes) / 2);
    scene.add(at.array() - 10, at.array() + 2e6); // the middle of all is a million away from the grid
    kd->find_pairs(scene.boxes, scene.all, scene.filter(), 0, 1, pairs);
    EXPECT_EQ(pairs.size(), (neighbours - boxes) / 2 + boxes);
    for (Aabb& box : scene.boxes) box.max.array() -= 1e-3; // nothing touches any more, but for the giant
    kd->find_pairs(scene.boxes, scene.all, scene.filter(), 0, 1, pairs);
    EXPECT_EQ(pairs.size(), boxes);
}

TEST(KdTree, GivesTheSameListOnManyThreads)
{
    Boxes scene = random_boxes(60000, 70, 0.3, 19, {0, 0, 0});
    std::vector<BodyPair> octree, kd;
    make_octree()->find_pairs(scene.boxes, scene.all, scene.filter(), 0, 1, octree);
    for (int threads : {1, 2, 5, 40}) {
        make_kd_tree()->find_pairs(scene.boxes, scene.all, scene.filter(), 0, threads, kd);
        EXPECT_EQ(kd, octree) << threads;
    }
    const auto tree = make_kd_tree();
    tree->find_pairs(scene.boxes, scene.all, scene.filter(), 0, 4, kd);
    EXPECT_LT(tree->bytes(), 120 * scene.boxes.size());
}

} // namespace
} // namespace oncollide
