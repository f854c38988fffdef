// Space::overlaps of segments, compared with the tests of pairs for a triangle of the same shape.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>

#include "every_kind.hpp"
#include "pipeline/queries/cooked_hills.hpp"
#include "random_pose.hpp"

namespace oncollide::segments_test {
namespace {

using Eigen::Vector3d;

Vector3d random_point(std::uint64_t seed, std::uint64_t i, double reach)
{
    return reach * (2 * Vector3d(u01(seed, i, 0), u01(seed, i, 1), u01(seed, i, 2)).array() - 1);
}

/// Bodies of all kinds but half-spaces, in a heap.
void add_heap(World& world, std::uint64_t bodies, double reach)
{
    for (std::uint64_t i = 0; i < bodies; ++i) {
        const ModelId model = world.models().add(std::make_shared<const Geometry>(
            Geometry{"", draw_geometry(static_cast<std::size_t>(i % (kinds - 1)), i), ""}));
        world.bodies().add({.model = model,
                            .pose = random_pose(i, reach),
                            .is_static = i % 3 == 0,
                            .layer = static_cast<std::uint32_t>(1 + i % 2)});
    }
}

std::vector<std::uint32_t> slots(const std::vector<QueryHit>& hits)
{
    std::vector<std::uint32_t> slots;
    for (const QueryHit& hit : hits) slots.push_back(hit.body.slot);
    return slots;
}

TEST(Segments, HitWhatAModelOfTheSameShapeHits)
{
    for (const Mode mode : {Mode::surface, Mode::solid}) {
        World world({.exact = ExactLevel::predicates, .mode = mode, .open_as_surface = mode == Mode::solid});
        add_heap(world, 120, 2.5);
        std::size_t found = 0;
        for (std::uint64_t k = 0; k < 300; ++k) {
            const Vector3d from = random_point(1, k, 4),
                           to = k % 3 ? random_point(2, k, 4) : Vector3d(from + random_point(3, k, 0.05));
            const ModelId same = world.models().add(make_mesh("segment", {from, to}, {{0, 1, 1}}));
            const CollisionFilter filter{.mask = k % 2 ? ~0u : 2u};
            const auto hits = world.space().overlaps(Segment{from, to}, filter);
            EXPECT_EQ(slots(hits), slots(world.space().overlaps(PlacedModel{same}, filter))) << k;
            EXPECT_TRUE(std::ranges::is_sorted(slots(hits)));
            world.models().remove(same);
            found += hits.size();
        }
        EXPECT_GT(found, 300u);
    }
}

TEST(Segments, InsideAClosedMeshHitItInSolidModeAlone)
{
    for (const Mode mode : {Mode::surface, Mode::solid}) {
        World world({.mode = mode});
        const BodyId ball = world.bodies().add({.model = world.models().add(make_sphere_mesh(1, 500))});
        const auto hits = world.space().overlaps(Segment{{0, 0, 0}, {0.25, 0, 0}});
        ASSERT_EQ(hits.size(), mode == Mode::solid ? 1u : 0u);
        if (!hits.empty()) {
            EXPECT_EQ(hits[0].body, ball);
            EXPECT_EQ(hits[0].verdict, Verdict::colliding);
            EXPECT_EQ(hits[0].kind, ContactKind::enclosed);
        }
    }
    World world;
    world.bodies().add({.model = world.models().add(Shape(Box{{1, 1, 1}}))});
    EXPECT_EQ(world.space().overlaps(Segment{{0, 0, 0}, {0.25, 0, 0}}).size(), 1u) << "shapes are solid";
    EXPECT_EQ(world.space().overlaps(Segment{{0, 0, 0}, {0, 0, 0}}).size(), 1u) << "a point";
}

TEST(Segments, AreExactWhateverTheSettings)
{
    for (Settings settings : {Settings{.max_error = 0.5}, Settings{.max_error = 0.5, .clearance = 0.125},
                              Settings{.exact = ExactLevel::predicates, .contact_kinds = true, .threads = 2}}) {
        World world(settings);
        const BodyId ground =
            world.bodies().add({.model = world.models().add(make_hills(64, 64, 1, 8, 3)), .is_static = true});
        std::vector<Segment> segments;
        for (std::uint64_t k = 0; k < 100; ++k)
            segments.push_back({Vector3d(64 * u01(5, k, 0), 64 * u01(5, k, 1), 20),
                                Vector3d(64 * u01(5, k, 2), 64 * u01(5, k, 3), k % 2 ? 20 : -20)});
        Lists<QueryHit> hits;
        world.space().overlaps(segments, {}, hits);
        ASSERT_EQ(hits.offsets.size(), segments.size() + 1);
        for (std::size_t k = 0; k < segments.size(); ++k) {
            ASSERT_EQ(hits.offsets[k + 1] - hits.offsets[k], k % 2 ? 0u : 1u) << k;
            EXPECT_EQ(world.space().overlaps(segments[k]).size(), k % 2 ? 0u : 1u) << k;
            if (k % 2) continue;
            const QueryHit& hit = hits.items[hits.offsets[k]];
            EXPECT_EQ(hit.body, ground);
            if (settings.clearance == 0) {
                EXPECT_EQ(hit.verdict, Verdict::colliding) << k;
            }
        }
    }
}

TEST(Segments, ReadTheChunksOfACookedMeshThatTheyMeet)
{
    test::CookedHills hills;
    std::size_t hit = 0;
    for (std::uint64_t k = 0; k < 100; ++k) {
        const Segment segment = test::CookedHills::segment(k);
        const bool meets = !hills.whole.space().overlaps(segment).empty();
        EXPECT_EQ(!hills.parts.space().overlaps(segment).empty(), meets) << k;
        hit += meets;
    }
    EXPECT_GT(hit, 20u);
    EXPECT_LT(hit, 100u);
}

TEST(Segments, AreRefusedIfTheyAreNotFinite)
{
    World world;
    world.bodies().add({.model = world.models().add(make_sphere_mesh(1, 500))});
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e16}) {
        const std::vector<Segment> segments{{{0, 0, 0}, {1, 0, 0}}, {{0, 0, 0}, {0, bad, 0}}};
        Lists<QueryHit> hits;
        try {
            world.space().overlaps(segments, {}, hits);
            FAIL() << bad;
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::bad_data);
            EXPECT_EQ(std::string(error.what()).substr(0, 10), "overlaps 1") << error.what();
        }
    }
}

} // namespace
} // namespace oncollide::segments_test
