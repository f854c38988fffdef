// Properties of only the kd-tree and the octree: delimitation, threads, memory.
#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

#include "broadphase/boxes.hpp"

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/broadphase/tree/dynamic_tree.hpp>

namespace oncollide {
namespace {

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
    // Each box touches the 26 around it: (3 side - 2)^3 ordered pairs of neighbours, pairs of a box with itself
    // included.
    constexpr std::size_t boxes = side * side * side,
                          neighbours = std::size_t{3 * side - 2} * (3 * side - 2) * (3 * side - 2);
    const auto kd = make_kd_tree();
    scene.add_to(*kd);
    EXPECT_EQ(find(*kd, scene).size(), (neighbours - boxes) / 2);
    scene.add(at.array() - 10, at.array() + 2e6); // the centre of all boxes is a million away from the grid
    kd->add(std::span(scene.all).last(1));
    EXPECT_EQ(find(*kd, scene).size(), (neighbours - boxes) / 2 + boxes);
    for (Aabb& box : scene.boxes) box.max.array() -= 1e-3; // boxes no longer touch, except the giant
    kd->move(scene.all);
    EXPECT_EQ(find(*kd, scene).size(), boxes);
    EXPECT_EQ(find_anew(make_kd_tree(), scene).size(), boxes);
}

TEST(KdTree, GivesTheSameOnManyThreads)
{
    Boxes scene = random_boxes(60000, 75, 0.4, 29, {0, 0, 0});
    const auto one = make_kd_tree();
    scene.add_to(*one);
    const Pairs pairs = find(*one, scene);
    EXPECT_GT(pairs.size(), 10000u);
    EXPECT_EQ(find_anew(make_octree(), scene), pairs);
    EXPECT_EQ(find_anew(make_octree({.threads = 3}), scene), pairs);
    std::vector<std::unique_ptr<BroadPhase>> many;
    for (int threads : {2, 5, 40}) {
        many.push_back(make_kd_tree({.threads = threads}));
        scene.add_to(*many.back());
        EXPECT_EQ(find(*many.back(), scene), pairs) << threads;
    }
    Bodies moved;
    for (std::uint32_t body : scene.all)
        if (body % 5 == 0) moved.push_back(body), scene.step(body, random_step(1, body, 3));
    one->move(moved);
    one->delimit(scene.columns());
    const std::uint64_t left = one->bodies_left();
    const Pairs later = find(*one, scene);
    for (const auto& broad : many) {
        broad->move(moved);
        broad->delimit(scene.columns());
        EXPECT_EQ(broad->bodies_left(), left);
        EXPECT_EQ(find(*broad, scene), later);
    }
    EXPECT_LT(one->bytes(), 180 * scene.boxes.size());
}

/// A heap of boxes with the largest number of changes for which regions are examined.
TEST(Delimitation, IsTheSameForAnyNumberOfThreadsInAHeap)
{
    Boxes scene;
    for (std::uint32_t i = 0; i < 17000; ++i) {
        const Eigen::Vector3d at(3 * u01(2, i, 0), 3 * u01(2, i, 1), 3 * u01(2, i, 2));
        scene.add(at, at.array() + 1, false, 1, 1, 9);
    }
    for (const std::uint32_t moved : {10u, 4200u}) {
        std::vector<std::uint64_t> left;
        for (int threads : {1, 2, 7}) {
            const auto kd = make_kd_tree({.threads = threads});
            scene.add_to(*kd);
            EXPECT_TRUE(find(*kd, scene).empty());
            kd->move(std::span(scene.all).first(moved));
            kd->delimit(scene.columns());
            left.push_back(kd->bodies_left());
            EXPECT_TRUE(find(*kd, scene).empty());
            EXPECT_LT(kd->bytes(), 800 * scene.boxes.size());
        }
        EXPECT_EQ(left[0], left[1]);
        EXPECT_EQ(left[0], left[2]);
    }
}

/// The remaining bodies must include every pair, for any motion. The number of remaining regions of each level and kind
/// must equal levels(), and they must contain the remaining bodies.
void expect_regions_of(BroadPhase& tree, const Boxes& scene, const Bodies& left)
{
    const std::vector<DelimitedRegion> regions = tree.regions();
    ASSERT_EQ(regions.size(),
              std::accumulate(tree.levels().begin(), tree.levels().end(), std::uint64_t{0},
                              [](std::uint64_t n, const DelimitationLevel& l) { return n + l.regions; }));
    for (std::size_t level = 0; level < tree.levels().size(); ++level)
        EXPECT_EQ(std::uint64_t(std::ranges::count_if(
                      regions, [&](const DelimitedRegion& r) { return r.level == int(level) && r.rejected; })),
                  tree.levels()[level].regions_rejected);
    const int deepest = int(tree.levels().size()) - 1;
    for (std::uint32_t body : left)
        EXPECT_TRUE(std::ranges::any_of(regions, [&](const DelimitedRegion& r) {
            return r.level == deepest && !r.rejected && r.box.contains(scene.boxes[body]);
        })) << body;
}

TEST(Delimitation, LeavesEveryBodyOfAPair)
{
    Boxes scene = random_boxes(6000, 90, 0.985, 11, {0, 0, 0});
    const auto tree = make_kd_tree({.margin = 0.05});
    scene.add_to(*tree);
    Bodies moving, left;
    for (std::uint32_t body : scene.all)
        if (!scene.is_static[body]) moving.push_back(body);
    tree->find_pairs(scene.columns());
    for (int frame = 0; frame < 30; ++frame) {
        tree->move(moving);
        tree->delimit(scene.columns());
        tree->survivors(left);
        ASSERT_TRUE(std::is_sorted(left.begin(), left.end()));
        EXPECT_EQ(tree->bodies_left(), left.size());
        for (BodyPair pair : scene.truth(0.05))
            for (std::uint32_t body : {pair.a, pair.b})
                ASSERT_TRUE(std::binary_search(left.begin(), left.end(), body)) << "frame " << frame;
        if (frame < 3) {
            EXPECT_LT(left.size(), scene.boxes.size() * 3 / 4) << "regions are rejected";
        }
        // Every region that does not remain was rejected once, level by level.
        std::uint64_t rejected = 0, regions = 1, survived = 1;
        for (const DelimitationLevel& level : tree->levels()) {
            EXPECT_LE(level.regions, 16 * survived);
            EXPECT_GE(level.volume_rejected, 0);
            EXPECT_LE(level.volume_rejected, 1);
            survived = level.regions - level.regions_rejected;
            rejected += level.bodies_rejected, regions += level.regions;
        }
        EXPECT_EQ(rejected + left.size(), scene.boxes.size());
        expect_regions_of(*tree, scene, left);
        EXPECT_GT(regions, 20u);
        if (frame % 2) tree->find_pairs(scene.columns());
        // All move to one corner and out of the space of the tree, too fast for enlarged boxes.
        for (std::uint32_t body : moving) scene.step(body, {-2.5, -1.0, 0.3 * (body % 5)});
    }
}

TEST(Delimitation, RejectsForbiddenLayersAndAllWhenNothingMoves)
{
    Boxes scene;
    for (int i = 0; i < 600; ++i) scene.add({10.0 * i, 0, 0}, {10.0 * i + 1, 1, 1}, true, 1, i < 300 ? 1 : 3);
    scene.add({2000, 0, 0}, {2001, 1, 1}, false, 2, 1); // nobody near it collides with layer 2
    scene.add({5000, 0, 0}, {5001, 1, 1}, false, 2, 3);
    const auto tree = make_kd_tree();
    scene.add_to(*tree);
    tree->delimit(scene.columns());
    Bodies left;
    tree->survivors(left);
    EXPECT_FALSE(std::binary_search(left.begin(), left.end(), 200u));
    EXPECT_TRUE(std::binary_search(left.begin(), left.end(), 500u));
    EXPECT_EQ(find(*tree, scene), (Pairs{{500, 601}}));
    tree->move({});
    tree->delimit(scene.columns());
    scene.layers[600] = 1; // now they do
    tree->move(Bodies{600});
    EXPECT_EQ(find(*tree, scene), (Pairs{{200, 600}, {500, 601}}));
    EXPECT_EQ(find(*tree, scene, true), (Pairs{{200, 600}, {500, 601}}));
    EXPECT_TRUE(tree->levels().empty()) << "all was searched";
    tree->make_static(Bodies{600, 601});
    EXPECT_TRUE(find(*tree, scene).empty());
    tree->delimit(scene.columns());
    ASSERT_FALSE(tree->levels().empty());
    EXPECT_EQ(tree->bodies_left(), 0u);
}

/// A body within its enlarged box meets another body, after the tree was rebuilt.
TEST(KdTree, FindsWhoDriftsOnInATreeThatGotALevelMore)
{
    Boxes scene;
    for (int i = 0; i < 240; ++i) scene.add({3.0 * i, 0, 0}, {3.0 * i + 1, 1, 1});
    const auto tree = make_kd_tree();
    scene.add_to(*tree);
    EXPECT_TRUE(find(*tree, scene).empty());
    const auto drift = [&] { scene.step(120, {0.1, 0, 0}), tree->move(Bodies{120}); };
    for (int frame = 0; frame < 3; ++frame) {
        drift();
        EXPECT_TRUE(find(*tree, scene).empty());
    }
    Bodies come;
    for (int i = 240; i < 270; ++i) scene.add({3.0 * i, 0, 0}, {3.0 * i + 1, 1, 1}), come.push_back(scene.all.back());
    tree->add(come);
    EXPECT_TRUE(find(*tree, scene).empty());
    drift();
    EXPECT_TRUE(find(*tree, scene).empty());
    drift();
    scene.boxes[7] = scene.boxes[120];
    scene.step(7, {0.95, 0, 0});
    tree->move(Bodies{7});
    EXPECT_EQ(find(*tree, scene), (Pairs{{7, 120}}));
}

/// Adds leaves at the end of a tree that stores layers, up to sizes at which it gets another level.
TEST(Delimitation, KnowsTheLayersOfBodiesThatAreAddedLittleByLittle)
{
    Boxes scene = random_boxes(5000, 40, 0.5, 37, {0, 0, 0});
    const auto tree = make_kd_tree();
    std::uint32_t there = 0;
    const auto add_up_to = [&](std::uint32_t end) {
        Bodies is_static, dynamic;
        for (; there < end; ++there) (scene.is_static[there] ? is_static : dynamic).push_back(there);
        tree->add(is_static, true), tree->add(dynamic);
    };
    for (const std::uint32_t end : {200u, 240u, 250u, 258u, 300u, 360u, 4000u, 4090u, 4097u, 4200u, 5000u}) {
        add_up_to(end);
        Pairs expected = scene.truth();
        std::erase_if(expected, [&](BodyPair p) { return p.b >= end; });
        EXPECT_EQ(find(*tree, scene), expected) << end;
        EXPECT_EQ(find(*tree, scene, true), expected) << end;
    }
}

TEST(DynamicTree, FindsThePairsOfABodyThatMakesTheTreeTaller)
{
    for (const bool forbid : {false, true})
        for (const std::uint32_t count : {3u, 15u, 16u, 17u, 255u, 256u, 257u}) {
            const auto tree = make_kd_tree();
            const std::vector<Aabb> boxes(count + 1, Aabb{{0, 0, 0}, {1, 1, 1}});
            std::vector<std::uint32_t> bodies(count), layers(count + 1, 1), masks(count + 1, ~0u);
            std::iota(bodies.begin(), bodies.end(), 0u);
            if (forbid) layers[0] = masks[0] = 2;
            const BodyColumns columns{boxes, layers, masks};
            tree->add(bodies);
            tree->find_pairs(columns, true);
            tree->add({&count, 1});
            const std::size_t all = count * (count + 1) / 2;
            EXPECT_EQ(tree->find_pairs(columns, true).size(), forbid ? all - count : all) << count;
        }
}

/// Bodies come, go, drift, jump and change their filters; after each frame the whole structure is examined.
TEST(DynamicTree, IsWithoutFaultAfterEveryFrame)
{
    Boxes scene = random_boxes(3000, 40, 0.5, 41, {0, 0, 0});
    for (const AabbOrder order : {AabbOrder::kd, AabbOrder::octree}) {
        DynamicTree tree("tree", order, {.margin = 0.01});
        scene.add_to(tree);
        for (std::uint32_t frame = 0; frame < 40; ++frame) {
            Bodies moved;
            for (std::uint32_t body : scene.all) {
                const double choice = u01(frame, body, 9);
                if (choice < 0.02 || !tree.contains(body)) {
                    tree.contains(body) ? tree.remove(Bodies{body}) : tree.add(Bodies{body}, body % 2);
                } else if (choice < (frame % 10 == 9 ? 0.9 : 0.2)) {
                    scene.step(body, random_step(frame, body, choice < 0.05 ? 20 : 0.05)), moved.push_back(body);
                    if (choice < 0.03) scene.groups[body] = 3, scene.layers[body] = 2;
                }
            }
            tree.move(moved);
            tree.find_pairs(scene.columns(), frame % 13 == 12);
            ASSERT_EQ(tree.validate(scene.columns()), "") << "frame " << frame;
        }
    }
}

TEST(DynamicTree, NamesABodyWhoseMotionItWasNotTold)
{
    Boxes scene = random_boxes(1000, 20, 0.5, 43, {0, 0, 0});
    DynamicTree tree("tree", AabbOrder::kd, {});
    scene.add_to(tree);
    tree.find_pairs(scene.columns(), false);
    EXPECT_EQ(tree.validate(scene.columns()), "");
    scene.step(77, {1, 0, 0});
    const std::string fault = tree.validate(scene.columns());
    EXPECT_NE(fault.find("does not enclose its body 77"), std::string::npos) << fault;
    scene.step(77, {-1, 0, 0});
    tree.move(Bodies{5});
    EXPECT_EQ(tree.validate(scene.columns()), "") << "changes are pending, but the tree is whole";
    tree.remove(Bodies{5});
    EXPECT_NE(tree.validate(scene.columns()), "") << "the tree still holds it";
}

} // namespace
} // namespace oncollide
