// The comparators that drop pairs by occlusion queries, against exact truth.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <tuple>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/gl/culling/pair_culling.hpp>
#include <oncollide/narrowphase/gl/gpu.hpp>
#include <oncollide/samples/generators.hpp>

#include "random_pose.hpp"
#include "truth/truth.hpp"

namespace oncollide::pair_culling_test {
namespace {

/// Meshes at random poses in a cube, and the pairs whose boxes overlap.
struct Crowd {
    std::vector<Mesh> meshes;
    std::vector<CulledBody> bodies;
    std::vector<BodyPair> pairs;
};

Mesh scaled(const Mesh& mesh, double scale)
{
    return transformed("scaled", mesh, scale, Eigen::Vector3d::Zero());
}

std::vector<Mesh> ordinary()
{
    return {make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300), make_gear_mesh(8, 0.8, 1.2, 0.3, 0.3),
            make_box_mesh({0.5, 0.7, 0.9})};
}

std::vector<Mesh> thin()
{
    return {make_needles_mesh(30, 1, 1e5, 2, 7), make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300),
            make_soup_mesh(300, 1e-3, 0.5, 9)};
}

Crowd crowd(const std::vector<Mesh>& kinds, int count, double room, double scale, std::uint64_t seed)
{
    Crowd made;
    for (const Mesh& mesh : kinds) made.meshes.push_back(scaled(mesh, scale));
    std::vector<Aabb> boxes;
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(count); ++i) {
        const Eigen::Isometry3d pose = random_pose(1000 * seed + i, scale * room);
        const std::uint32_t mesh = i % static_cast<std::uint32_t>(kinds.size());
        made.bodies.push_back({mesh, pose});
        Aabb& box = boxes.emplace_back();
        for (const Eigen::Vector3d& v : made.meshes[mesh].vertices) box.add(pose * v);
        for (std::uint32_t k = 0; k < i; ++k)
            if (boxes[k].overlaps(box)) made.pairs.push_back({k, i});
    }
    return made;
}

struct Score {
    int colliding = 0, missed = 0, separate = 0, dropped = 0;
    std::uint64_t queries = 0;
};

Score score(PairCulling& culling, const Crowd& crowd)
{
    for (std::uint32_t i = 0; i < crowd.meshes.size(); ++i) culling.attach(i, crowd.meshes[i]);
    std::vector<std::uint8_t> left(crowd.pairs.size(), 7);
    Score sum;
    sum.queries = culling.cull(crowd.bodies, crowd.pairs, left).queries;
    std::vector<std::unique_ptr<tools::TruthModel>> models;
    for (const Mesh& mesh : crowd.meshes) models.push_back(std::make_unique<tools::TruthModel>(mesh, false));
    for (std::size_t i = 0; i < left.size(); ++i) {
        const CulledBody &a = crowd.bodies[crowd.pairs[i].a], &b = crowd.bodies[crowd.pairs[i].b];
        const bool meet =
            tools::truth_of(*models[a.mesh], a.pose, *models[b.mesh], b.pose, {.kinds = false, .distance = false})
                .collide;
        EXPECT_LE(left[i], 1);
        sum.colliding += meet, sum.missed += meet && !left[i];
        sum.separate += !meet, sum.dropped += !meet && !left[i];
    }
    return sum;
}

TEST(PairCulling, FattenedMissesNoCollision)
{
    for (const auto& [viewport, subset, scale] :
         {std::tuple{16, 1, 1.0}, {64, 32, 1e-9}, {64, 8, 1e9}, {128, 8, 1.0}, {512, 32, 1.0}}) {
        const auto far = make_cullide({.viewport = viewport, .subset = subset, .fattened = true});
        for (const auto& kinds : {ordinary(), thin()}) {
            SCOPED_TRACE(far->name() + " at " + std::to_string(scale));
            const Score found = score(*far, crowd(kinds, 18, 2.2, scale, 5));
            EXPECT_GT(found.colliding, 5);
            EXPECT_EQ(found.missed, 0);
        }
    }
}

TEST(PairCulling, FattenedMissesNoneOfManySmallBodiesInALargeRoom)
{
    // Each body is about a pixel large.
    const auto far = make_cullide({.viewport = 64, .fattened = true});
    const Score found = score(*far, crowd(ordinary(), 300, 20, 0.1, 3));
    EXPECT_GT(found.colliding, 20);
    EXPECT_EQ(found.missed, 0);
}

TEST(PairCulling, PlainQueriesMissWhatNoPixelSees)
{
    const Crowd needles = crowd(thin(), 18, 2.2, 1, 5);
    for (const auto& culling : {make_cullide({.viewport = 128}), make_viewing_volumes()}) {
        const Score found = score(*culling, needles);
        EXPECT_GT(found.missed, 0) << culling->name();
    }
}

TEST(PairCulling, DropsPairsThatAreApart)
{
    const Crowd bodies = crowd(ordinary(), 24, 3, 1, 11);
    for (const auto& culling :
         {make_cullide(), make_cullide({.viewport = 1024, .fattened = true}), make_viewing_volumes()}) {
        const Score found = score(*culling, bodies);
        EXPECT_GT(found.separate, 10);
        EXPECT_GT(found.dropped, 2) << culling->name();
        EXPECT_LT(found.missed, found.colliding / 4 + 1) << culling->name();
        EXPECT_GT(found.queries, 0u);
    }
}

TEST(PairCulling, KeepsABodyInsideAnotherAndBodiesThatTouch)
{
    Crowd two{.meshes = {make_box_mesh({1, 1, 1}), make_box_mesh({0.25, 0.25, 0.25})}, .bodies = {}, .pairs = {{0, 1}}};
    two.bodies = {{0, Eigen::Isometry3d::Identity()}, {1, Eigen::Isometry3d::Identity()}};
    const auto left_over = [&](PairCulling& culling) {
        for (std::uint32_t i : {0u, 1u}) culling.attach(i, two.meshes[i]);
        std::vector<std::uint8_t> left(1);
        culling.cull(two.bodies, two.pairs, left);
        return left[0];
    };
    const auto far = make_cullide({.fattened = true}), plain = make_cullide();
    EXPECT_EQ(left_over(*far), 1);
    EXPECT_EQ(left_over(*plain), 1);
    two.bodies[1].pose.translation() << 1.25, 0.5, 0;
    EXPECT_EQ(left_over(*far), 1) << "they touch";
    two.bodies[1].pose.translation() << 1.35, 0.5, 0;
    EXPECT_EQ(left_over(*far), 0) << "they are apart by many pixels";
}

TEST(PairCulling, DropsAllWithoutBodiesAndTakesAMeshAnew)
{
    for (const auto& culling : {make_cullide(), make_viewing_volumes()}) {
        EXPECT_EQ(culling->cull({}, {}, {}).queries, 0u);
        culling->attach(0, make_box_mesh({1, 1, 1}));
        culling->attach(0, make_box_mesh({9, 9, 9}));
        std::vector<CulledBody> two(2, {0, Eigen::Isometry3d::Identity()});
        two[1].pose.translation() << 3, 3, 3;
        std::vector<std::uint8_t> left(1);
        culling->cull(two, std::vector<BodyPair>{{0, 1}}, left);
        EXPECT_EQ(left[0], 1) << culling->name() << ": they would be apart by the first mesh";
    }
}

TEST(PairCulling, NamesItsOptionsAndRefusesWhatMakesNoSense)
{
    EXPECT_EQ(make_cullide({.viewport = 64, .fattened = true})->name(), "CULLIDE (64 px, fattened)");
    EXPECT_EQ(make_cullide()->renderer(), describe_gpu(-1).renderer);
    EXPECT_EQ(make_viewing_volumes()->name(), "viewing volumes (64 px, 8 per body)");
    for (const std::function<void()>& make : std::vector<std::function<void()>>{
             [] { make_cullide({.viewport = 15}); }, [] { make_cullide({.viewport = 1025}); },
             [] { make_cullide({.subset = 0}); }, [] { make_viewing_volumes({.viewport = 0}); },
             [] { make_viewing_volumes({.volumes = 0}); }}) {
        try {
            make();
            ADD_FAILURE() << "accepted";
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::usage);
        }
    }
}

} // namespace
} // namespace oncollide::pair_culling_test
