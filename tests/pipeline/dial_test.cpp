// The error bound of a pair, which refinement must satisfy.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::test {
namespace {

/// A ground of 200 m, crates of 0.2 m and of 40 m on and above it.
struct Yard {
    World world;
    BodyId ground;
    std::vector<BodyId> small, large;

    explicit Yard(const Settings& settings, std::vector<int> order = {0, 1, 2}) : world(settings)
    {
        const ModelId models[] = {world.models().add(make_box_mesh({100, 100, 1}), "ground"),
                                  world.models().add(make_sphere_mesh(1, 800), "ball"),
                                  world.models().add(make_box_mesh({10, 10, 20}), "tower")};
        std::mt19937 random(7);
        std::uniform_real_distribution<double> place(-90, 90), above(-0.2, 0.6);
        std::vector<BodySpec> specs[3];
        specs[0].push_back({.model = models[0], .is_static = true});
        for (int i = 0; i < 60; ++i) { // every second sphere is at a tower
            const Eigen::Vector2d far(place(random), place(random)), near(0.1 * place(random), 0.1 * place(random));
            Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
            if (i % 10 == 0) {
                pose.translation() << far, 21 + above(random);
                specs[2].push_back({.model = models[2], .pose = pose});
            }
            const Eigen::Vector2d at = i % 2 ? far : specs[2].back().pose.translation().head<2>() + near;
            pose.translation() << at, 2 + 0.2 * above(random);
            specs[1].push_back({.model = models[1], .pose = pose});
        }
        for (int k : order)
            for (const BodySpec& spec : specs[k]) {
                const BodyId id = world.bodies().add(spec);
                k == 0 ? void(ground = id) : (k == 1 ? small : large).push_back(id);
            }
    }
};

class Dial : public testing::TestWithParam<BoundingVolume> {};

TEST_P(Dial, GivesEachPairOnePercentOfTheSmallerBody)
{
    Yard yard({.exact = ExactLevel::off, .bounding_volume = GetParam()});
    const double ball = 0.01 * 2 * std::sqrt(3.0), tower = 0.01 * 2 * std::sqrt(600.0);
    EXPECT_NEAR(yard.world.pairs().max_error(yard.ground, yard.small[0]), ball, 0.01 * ball);
    EXPECT_NEAR(yard.world.pairs().max_error(yard.large[0], yard.small[0]), ball, 0.01 * ball);
    EXPECT_NEAR(yard.world.pairs().max_error(yard.large[0], yard.ground), tower, 1e-9);
    int within = 0, wide = 0;
    for (const PairResult& pair : yard.world.step().pairs) {
        const double error = yard.world.pairs().max_error(pair.a, pair.b);
        const Distance distance = yard.world.pairs().distance(pair.a, pair.b, {.tolerance = 1e-9});
        if (pair.verdict == Verdict::separate) {
            EXPECT_GT(distance.upper, 0);
            EXPECT_LE(pair.bound, distance.upper * (1 + 1e-9));
            continue;
        }
        ASSERT_EQ(pair.verdict, Verdict::within);
        EXPECT_GE(pair.bound, distance.lower);
        EXPECT_LE(pair.bound, error);
        ++within, wide += pair.bound > ball;
    }
    EXPECT_GE(within, 20);
    EXPECT_GE(wide, 2) << "the towers, whose error is larger";
}

TEST_P(Dial, IsKeptByWithinHoweverSmallItIs)
{
    const bool spheres = GetParam() == BoundingVolume::sphere;
    for (const double error : {4e-6, 1e-3}) {
        World world({.max_error = error, .bounding_volume = GetParam()});
        const ModelId ball = world.models().add(make_sphere_mesh(1, 800), "ball"),
                      box = world.models().add(make_box_mesh({1, 2, 3}), "box");
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        const BodyId a = world.bodies().add({.model = box, .pose = pose});
        pose.translation() << 1.9, 0.3, 0.2;
        const BodyId b = world.bodies().add({.model = ball, .pose = pose});
        for (const Finding& found : {world.pairs().decide(a, b), Finding(world.step().pairs[0])}) {
            // The deepest spheres are 2^-16 of the bodies.
            EXPECT_EQ(found.verdict, spheres && error < 1e-4 ? Verdict::undecided : Verdict::within);
            if (found.verdict == Verdict::within) {
                EXPECT_LE(found.bound, error);
            }
            EXPECT_LT(found.bound, 0.01);
        }
    }
}

TEST_P(Dial, IsThatOfThePairWhateverOtherPairsNeed)
{
    const auto results = [&](std::vector<int> order, int together) {
        Yard yard({.bounding_volume = GetParam()}, order);
        std::map<std::array<double, 6>, std::pair<Verdict, double>> found;
        for (int frame = 0; frame < 2; ++frame) { // the second frame has trees that other pairs have refined
            if (frame == 0 && !together)
                for (BodyId ball : yard.small) yard.world.bodies().set_filter(ball, {.layer = 2, .mask = 2});
            else
                for (BodyId ball : yard.small) yard.world.bodies().set_filter(ball, {});
            const auto pairs = yard.world.step().pairs;
            found.clear();
            for (const PairResult& pair : pairs) {
                std::array<double, 6> key;
                Eigen::Vector3d a = yard.world.bodies().pose(pair.a).translation(),
                                b = yard.world.bodies().pose(pair.b).translation();
                if (std::ranges::lexicographical_compare(b, a)) std::swap(a, b);
                std::copy_n(a.data(), 3, key.begin()), std::copy_n(b.data(), 3, key.begin() + 3);
                found[key] = {pair.verdict, pair.verdict == Verdict::within ? pair.bound : 0};
            }
        }
        return found;
    };
    const auto first = results({0, 1, 2}, 1);
    EXPECT_EQ(results({0, 1, 2}, 0), first) << "the small crates come later, and refine the ground's tree";
    const auto other = results({2, 0, 1}, 1);
    ASSERT_EQ(other.size(), first.size());
    for (const auto& [key, result] : first) {
        ASSERT_TRUE(other.contains(key));
        EXPECT_EQ(other.at(key).first, result.first);
        EXPECT_NEAR(other.at(key).second, result.second, 1e-4 * result.second + 1e-4)
            << "rounding depends on which body is A";
    }
}

INSTANTIATE_TEST_SUITE_P(Volumes, Dial, testing::Values(BoundingVolume::sphere, BoundingVolume::obb),
                         [](const auto& kind) { return std::string(name_of(kind.param)); });

TEST(DialSettings, ADepthMeansSphereTreesAndMetresBoxes)
{
    EXPECT_TRUE(wants_obbs({}));
    EXPECT_TRUE(wants_obbs({.max_error = 0.1}));
    EXPECT_FALSE(wants_obbs({.depth = 6}));
    EXPECT_TRUE(wants_obbs({.depth = 6, .exact = ExactLevel::predicates}));
    EXPECT_FALSE(wants_obbs({.backend = BackendKind::gl_compute}));
    EXPECT_TRUE(wants_obbs({.depth = 6, .bounding_volume = BoundingVolume::obb}));
}

TEST(DialSettings, OnlyOcclusionQueriesThatCanDecideAPairAreNotCertified)
{
    const auto query = BackendKind::gl_query;
    EXPECT_TRUE(certified({}));
    EXPECT_TRUE(certified({.backend = BackendKind::gl_compute}));
    EXPECT_FALSE(certified({.backend = query}));
    EXPECT_FALSE(certified({.depth = 6, .exact = ExactLevel::fcl, .backend = query}));
    EXPECT_TRUE(certified({.exact = ExactLevel::predicates, .backend = query})) << "exact tests decide all pairs";
    EXPECT_FALSE(certified({.exact = ExactLevel::predicates, .backend = query, .skip = {StageId::exact}}));
    EXPECT_FALSE(
        certified({.exact = ExactLevel::predicates, .backend = query, .bounding_volume = BoundingVolume::sphere}));
}

} // namespace
} // namespace oncollide::test
