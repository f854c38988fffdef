#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/broadphase/delimitation.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide {
namespace {

/// Bodies as boxes alone.
struct Boxes {
    std::vector<Aabb> boxes;
    std::vector<std::uint8_t> is_static;
    std::vector<std::uint32_t> layers, masks, all;

    void add(const Eigen::Vector3d& min, const Eigen::Vector3d& max, bool fixed = false, std::uint32_t layer = 1,
             std::uint32_t mask = ~0u)
    {
        Aabb box;
        box.min = min, box.max = max;
        all.push_back(static_cast<std::uint32_t>(boxes.size()));
        boxes.push_back(box), is_static.push_back(fixed), layers.push_back(layer), masks.push_back(mask);
    }
    BodyFilter filter() const { return {is_static, layers, masks}; }

    std::vector<BodyPair> truth(double margin) const
    {
        std::vector<BodyPair> pairs;
        for (std::uint32_t a = 0; a < boxes.size(); ++a)
            for (std::uint32_t b = a + 1; b < boxes.size(); ++b) {
                const bool apart = ((boxes[a].min - boxes[b].max).array() > margin).any() ||
                                   ((boxes[b].min - boxes[a].max).array() > margin).any();
                if (!apart && filter().allows(a, b)) pairs.push_back({a, b});
            }
        return pairs;
    }
};

Boxes random_boxes(std::uint32_t count, double side, double static_share, std::uint64_t seed, const Eigen::Vector3d& at)
{
    Boxes scene;
    for (std::uint32_t i = 0; i < count; ++i) {
        Eigen::Vector3d centre, half;
        for (std::uint64_t k = 0; k < 3; ++k)
            centre[static_cast<int>(k)] = side * u01(seed, i, k),
            half[static_cast<int>(k)] = 0.25 + 0.25 * u01(seed, i, 3 + k);
        if (i % 50 == 0) half *= 8;
        scene.add(at + centre - half, at + centre + half, u01(seed, i, 6) < static_share, 1u << (i % 3),
                  i % 7 == 0 ? 0b011u : ~0u);
    }
    return scene;
}

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

TEST_P(EveryBroadPhase, NeverLacksAPairFarFromTheOrigin)
{
    const Boxes scene = random_boxes(600, 12, 0.2, 5, {1e6, -2e6, 1e8});
    const auto found = find(scene);
    for (BodyPair pair : scene.truth(0)) EXPECT_TRUE(std::binary_search(found.begin(), found.end(), pair));
    EXPECT_LE(found.size(), scene.truth(1e-4).size());
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

INSTANTIATE_TEST_SUITE_P(, EveryBroadPhase,
                         ::testing::Values(Algorithm{"kd", make_kd_tree}, Algorithm{"octree", make_octree},
                                           Algorithm{"brute", make_brute_force}),
                         [](const auto& param) { return param.param.name; });

TEST(KdTree, FollowsWhatMovesFrameByFrame)
{
    for (const double margin : {0.0, 0.3}) {
        Boxes scene = random_boxes(3000, 22, 0.3, 13, {5, -3, 1e3});
        const auto kd = make_kd_tree(), brute = make_brute_force();
        std::vector<BodyPair> pairs, expected;
        kd->find_pairs(scene.boxes, scene.all, scene.filter(), margin, 1, pairs);
        std::vector<std::uint32_t> moved;
        for (std::uint64_t frame = 0; frame < 40; ++frame) {
            // None, one, some, most; a little, and now and then to the other end of the world.
            const double share = std::array{0.0, 0.0004, 0.05, 0.2, 0.6}[frame % 5];
            moved.clear();
            for (std::uint32_t body : scene.all) {
                if (scene.is_static[body] || u01(frame, body, 0) >= share) continue;
                moved.push_back(body);
                const double reach = frame % 7 == 6 ? 60 : 0.4;
                const Eigen::Vector3d step =
                    reach *
                    (Eigen::Vector3d(u01(frame, body, 1), u01(frame, body, 2), u01(frame, body, 3)).array() - 0.5);
                scene.boxes[body].min += step, scene.boxes[body].max += step;
            }
            kd->update_pairs(scene.boxes, scene.all, moved, moved, scene.filter(), margin, 1 + int(frame % 2), pairs);
            brute->find_pairs(scene.boxes, scene.all, scene.filter(), margin, 1, expected);
            ASSERT_EQ(pairs, expected) << "frame " << frame << ", " << moved.size() << " moved";
        }
    }
}

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

TEST(Delimitation, KeepsEveryPairWhileMoversWander)
{
    Boxes scene = random_boxes(3000, 60, 0.97, 11, {0, 0, 0});
    Delimitation delimitation;
    std::vector<std::uint32_t> survivors;
    for (int frame = 0; frame < 30; ++frame) {
        delimitation.run(scene.boxes, scene.filter(), 0.05, survivors);
        ASSERT_TRUE(std::is_sorted(survivors.begin(), survivors.end()));
        for (BodyPair pair : scene.truth(0.05)) {
            EXPECT_TRUE(std::binary_search(survivors.begin(), survivors.end(), pair.a)) << "frame " << frame;
            EXPECT_TRUE(std::binary_search(survivors.begin(), survivors.end(), pair.b)) << "frame " << frame;
        }
        EXPECT_LT(survivors.size(), scene.boxes.size() * 3 / 4) << "rejects regions without movers";
        for (std::uint32_t body : scene.all)
            if (!scene.is_static[body]) { // all wander to one corner, and out of the built space
                const Eigen::Vector3d step(-1.5, -1.0, 0.3 * (body % 5));
                scene.boxes[body].min += step, scene.boxes[body].max += step;
            }
    }
}

TEST(Delimitation, GrowsEveryBoxByTheMargin)
{
    for (const double margin : {0.5, 3.0}) {
        const Boxes scene = random_boxes(1500, 120, 0.97, 21, {0, 0, 0});
        Delimitation delimitation;
        std::vector<std::uint32_t> survivors;
        delimitation.run(scene.boxes, scene.filter(), margin, survivors);
        const auto pairs = scene.truth(margin);
        EXPECT_GT(pairs.size(), scene.truth(0).size());
        for (BodyPair pair : pairs) {
            EXPECT_TRUE(std::binary_search(survivors.begin(), survivors.end(), pair.a)) << "margin " << margin;
            EXPECT_TRUE(std::binary_search(survivors.begin(), survivors.end(), pair.b)) << "margin " << margin;
        }
        EXPECT_LT(survivors.size(), scene.boxes.size());
    }
}

TEST(Delimitation, RejectsALoneMoverAndForbiddenLayers)
{
    Boxes scene;
    for (int i = 0; i < 40; ++i) scene.add({10.0 * i, 0, 0}, {10.0 * i + 1, 1, 1}, true, 1, 1);
    scene.add({0, 50, 0}, {1, 51, 1}, false, 1, 1);
    scene.add({200, 0, 0}, {201, 1, 1}, false, 2, 2);
    Delimitation delimitation;
    std::vector<std::uint32_t> survivors;
    delimitation.run(scene.boxes, scene.filter(), 0, survivors);
    EXPECT_FALSE(std::binary_search(survivors.begin(), survivors.end(), 41u)) << "collides with no layer around it";
    std::uint64_t rejected = 0;
    for (const DelimitationLevel& level : delimitation.levels()) rejected += level.regions_rejected;
    EXPECT_GT(rejected, 0u);
}

} // namespace
} // namespace oncollide
