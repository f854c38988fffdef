// Space::cast, compared with Space::overlaps and with casts against one body at a time.
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

namespace oncollide::casts_test {
namespace {

std::optional<CastHit> first_hit(const World& world, const Segment& segment, const CollisionFilter& filter = {})
{
    const CastHit hit = world.space().cast(segment, filter);
    return hit.body ? std::optional(hit) : std::nullopt;
}

using Eigen::Vector3d;

Vector3d random_point(std::uint64_t seed, std::uint64_t i, double reach)
{
    return reach * (2 * Vector3d(u01(seed, i, 0), u01(seed, i, 1), u01(seed, i, 2)).array() - 1);
}

Segment draw(std::uint64_t k)
{
    const Vector3d from = random_point(1, k, 4);
    return {from, k % 3 ? random_point(2, k, 4) : Vector3d(from + random_point(3, k, 0.05))};
}

/// Bodies of all kinds in a heap, each twice at the same pose, and a half-space below.
void add_heap(World& world, std::uint64_t bodies)
{
    for (std::uint64_t i = 0; i < bodies; ++i) {
        const ModelId model = world.models().add(std::make_shared<const Geometry>(
            Geometry{"", draw_geometry(static_cast<std::size_t>(i % (kinds - 1)), i), ""}));
        const auto layer = static_cast<std::uint32_t>(1 + i % 2);
        for (int twice = 0; twice < 2; ++twice)
            world.bodies().add({.model = model, .pose = random_pose(i, 2.5), .is_static = i % 3 == 0, .layer = layer});
    }
    world.bodies().add(
        {.model = world.models().add(Shape(HalfSpace{})), .pose = Eigen::Isometry3d(Eigen::Translation3d(0, 0, -3))});
}

void expect_same(const CastHit& a, const CastHit& b)
{
    EXPECT_EQ(a.body, b.body);
    EXPECT_EQ(a.verdict, b.verdict);
    EXPECT_EQ(a.fraction_lower, b.fraction_lower);
    EXPECT_EQ(a.fraction_upper, b.fraction_upper);
    EXPECT_EQ(a.point, b.point);
    EXPECT_EQ(a.normal, b.normal);
    EXPECT_EQ(a.part, b.part);
}

TEST(Casts, HitWhatQueriesFindAndReturnTheFirst)
{
    for (const Mode mode : {Mode::surface, Mode::solid}) {
        World world({.exact = ExactLevel::predicates, .mode = mode});
        add_heap(world, 60);
        std::size_t found = 0;
        for (std::uint64_t k = 0; k < 300; ++k) {
            SCOPED_TRACE(k);
            const Segment segment = draw(k);
            const CollisionFilter filter{.mask = k % 2 ? ~0u : 2u};
            const std::vector<CastHit> all = world.space().cast_all(segment, filter);
            std::vector<std::uint32_t> hit, queried;
            for (const CastHit& h : all) hit.push_back(h.body.slot);
            for (const QueryHit& h : world.space().overlaps(segment, filter)) queried.push_back(h.body.slot);
            std::ranges::sort(hit);
            EXPECT_EQ(hit, queried);
            EXPECT_TRUE(std::ranges::is_sorted(all, {}, &CastHit::fraction_lower));
            const std::optional<CastHit> first = first_hit(world, segment, filter);
            ASSERT_EQ(first.has_value(), !all.empty());
            if (!first) continue;
            found += all.size();
            CastHit expected = all.front();
            double upper = 1;
            for (const CastHit& h : all) upper = std::min(upper, h.fraction_upper);
            for (const CastHit& h : all)
                if (h.fraction_lower <= upper && h.body.slot < expected.body.slot) expected = h;
            expected.fraction_lower = all.front().fraction_lower, expected.fraction_upper = upper;
            EXPECT_EQ(first->body, expected.body);
            EXPECT_EQ(first->part, expected.part);
            EXPECT_EQ(first->fraction_lower, expected.fraction_lower);
            EXPECT_EQ(first->fraction_upper, expected.fraction_upper);
            EXPECT_EQ(first->verdict, Verdict::colliding);
            const Vector3d at = segment.from + 0.5 * (first->fraction_lower + upper) * (segment.to - segment.from);
            EXPECT_LT((first->point - at).norm(), 1e-11);
            if (upper > 0 && !first->normal.isZero(0)) {
                EXPECT_NEAR(first->normal.norm(), 1, 1e-12);
                EXPECT_LT(first->normal.dot(segment.to - segment.from), 1e-6);
            }
        }
        EXPECT_GT(found, 400u);
    }
}

TEST(Casts, AreTheSameOneByOneAndInBatchesOnAnyNumberOfThreads)
{
    std::vector<Segment> segments;
    for (std::uint64_t k = 0; k < 400; ++k) segments.push_back(draw(k));
    std::vector<CastHit> one;
    for (const unsigned threads : {1u, 2u, 8u}) {
        World world({.exact = ExactLevel::predicates, .threads = static_cast<int>(threads)});
        add_heap(world, 60);
        std::vector<CastHit> hits(segments.size());
        world.space().cast(segments, {}, hits);
        if (one.empty()) one = hits;
        for (std::size_t k = 0; k < segments.size(); ++k) {
            SCOPED_TRACE(k);
            CastHit single = world.space().cast(segments[k]);
            EXPECT_EQ(single.body, hits[k].body);
            single.body.world = one[k].body.world; // another World
            CastHit same = hits[k];
            same.body.world = one[k].body.world;
            expect_same(single, one[k]), expect_same(same, one[k]);
        }
    }
    EXPECT_GT(std::ranges::count_if(one, [](const CastHit& hit) { return bool(hit.body); }), 100);
}

TEST(Casts, NameTheTriangleTheCellAndThePoint)
{
    World world;
    const BodyId box = world.bodies().add({.model = world.models().add(make_box_mesh({1, 1, 1})),
                                           .pose = Eigen::Isometry3d(Eigen::Translation3d(4, 0, 0))});
    const std::optional<CastHit> hit = first_hit(world, {{0, 0.25, 0.5}, {8, 0.25, 0.5}});
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->body, box);
    EXPECT_NEAR(hit->fraction_lower, 0.375, 1e-14);
    EXPECT_NEAR(hit->fraction_upper, 0.375, 1e-14);
    EXPECT_LT((hit->point - Vector3d(3, 0.25, 0.5)).norm(), 1e-13);
    EXPECT_EQ(hit->normal, Vector3d(-1, 0, 0));
    const std::optional<CastHit> along = first_hit(world, {{0, 0, 1}, {8, 0, 1}});
    ASSERT_TRUE(along) << "in the plane of the upper face";
    EXPECT_NEAR(along->fraction_upper, 0.375, 1e-14);
    EXPECT_FALSE(first_hit(world, {{0, 0, 1 + 0x1p-50}, {8, 0, 1 + 0x1p-50}}));
    const std::optional<CastHit> from_face = first_hit(world, {{3, 0.25, 0.5}, {0, 0.25, 0.5}});
    ASSERT_TRUE(from_face);
    EXPECT_EQ(from_face->fraction_upper, 0);

    World maps;
    OccupancyMap map = make_building_map(1, 0.5, 1);
    const Aabb bounds = map.bounds();
    maps.bodies().add({.model = maps.models().add(map)});
    const Vector3d above(bounds.min.x() + 0.1, bounds.min.y() + 0.1, bounds.max.z() + 1);
    const std::optional<CastHit> cell = maps.space().cast({above, above - Vector3d(0, 0, bounds.diagonal() + 2)});
    ASSERT_TRUE(cell);
    EXPECT_GT(cell->part.cell.side, 0);
    EXPECT_EQ(cell->normal, Vector3d::UnitZ());
    EXPECT_NEAR(map.box(cell->part.cell).max.z(), cell->point.z(), 1e-12);
}

TEST(Casts, OfCookedMeshesAreThoseOfTheWhole)
{
    test::CookedHills hills;
    std::size_t hits = 0;
    for (std::uint64_t k = 0; k < 100; ++k) {
        const Segment segment = test::CookedHills::segment(k);
        const std::optional<CastHit> a = first_hit(hills.whole, segment), b = first_hit(hills.parts, segment);
        ASSERT_EQ(a.has_value(), b.has_value()) << k;
        if (!a) continue;
        ++hits;
        EXPECT_EQ(a->part, b->part) << k;
        EXPECT_EQ(a->fraction_lower, b->fraction_lower) << k;
        EXPECT_EQ(a->fraction_upper, b->fraction_upper) << k;
    }
    EXPECT_GT(hits, 20u);
}

TEST(Casts, OfAMeshWithoutRoomForItsTreeAreUndecidedFromItsBox)
{
    World world({.memory_budget = 100'000});
    const BodyId mesh = world.bodies().add({.model = world.models().add(make_sphere_mesh(1, 100'000))});
    const BodyId wall = world.bodies().add({.model = world.models().add(Shape(Box{{0.25, 2, 2}})),
                                            .pose = Eigen::Isometry3d(Eigen::Translation3d(2.25, 0, 0))});
    const std::optional<CastHit> alone = first_hit(world, {{-4, 0, 0}, {0, 0, 0}});
    ASSERT_TRUE(alone);
    EXPECT_EQ(alone->body, mesh);
    EXPECT_EQ(alone->verdict, Verdict::undecided);
    EXPECT_NEAR(alone->fraction_lower, 0.75, 1e-3);
    EXPECT_EQ(alone->fraction_upper, 1);
    const std::optional<CastHit> certain = first_hit(world, {{-4, 0, 0}, {4, 0, 0}});
    ASSERT_TRUE(certain);
    EXPECT_EQ(certain->body, wall) << "the certain hit";
    EXPECT_EQ(certain->verdict, Verdict::colliding);
    EXPECT_NEAR(certain->fraction_lower, 0.375, 1e-3) << "the mesh may be nearer";
    EXPECT_NEAR(certain->fraction_upper, 0.75, 1e-14);
}

TEST(Casts, AreExactWithAllSettings)
{
    for (const Settings& settings : {Settings{.max_error = 0.5}, Settings{.max_error = 0.5, .clearance = 0.125},
                                     Settings{.exact = ExactLevel::predicates, .contact_kinds = true}}) {
        World world(settings);
        world.bodies().add({.model = world.models().add(Shape(Sphere{1}))});
        EXPECT_FALSE(first_hit(world, {{-4, 0, 1.0625}, {4, 0, 1.0625}}));
        const std::optional<CastHit> hit = first_hit(world, {{-4, 0, 0}, {4, 0, 0}});
        ASSERT_TRUE(hit);
        EXPECT_EQ(hit->verdict, Verdict::colliding);
        EXPECT_LE(hit->fraction_lower, 0.375);
        EXPECT_GE(hit->fraction_upper, 0.375);
    }
}

TEST(Casts, AreRefusedIfTheSegmentHasNoLengthOrIsNotFinite)
{
    World world;
    world.bodies().add({.model = world.models().add(make_sphere_mesh(1, 500))});
    const auto refuse = [&](const Segment& bad, const std::string& reason) {
        const std::vector<Segment> segments{{{0, 0, 0}, {1, 0, 0}}, bad};
        std::vector<CastHit> hits(2);
        try {
            world.space().cast(segments, {}, hits);
            FAIL() << reason;
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::bad_data);
            EXPECT_EQ(std::string(error.what()).find("cast 1: " + reason), 0u) << error.what();
        }
    };
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e31})
        refuse({{0, 0, 0}, {0, bad, 0}}, "a point of the segment is not finite");
    refuse({{1, 2, 3}, {1, 2, 3}}, "the segment has no length");
    std::vector<CastHit> room(1);
    EXPECT_THROW(world.space().cast(std::vector<Segment>{}, {}, room), Error);
}

TEST(Casts, FindABodyWhoseAabbBeginsJustBeforeTheNearestHit)
{
    World world;
    world.bodies().add(
        {.model = world.models().add(Shape(Sphere{1})), .pose = Eigen::Isometry3d(Eigen::Translation3d(5, 0, 0))});
    const BodyId plate = world.bodies().add({.model = world.models().add(Shape(Box{{0.01, 0.05, 0.05}})),
                                             .pose = Eigen::Isometry3d(Eigen::Translation3d(4.51, 0.9, 0))});
    const std::optional<CastHit> hit = first_hit(world, {{0, 0.9, 0}, {16, 0.9, 0}}); // it meets the sphere at 4.56
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->body, plate);
    EXPECT_NEAR(hit->point.x(), 4.5, 1e-12);
}

/// Few bodies are found without a search; the same ones among others far away are searched for.
TEST(Casts, OfFewBodiesAreThoseOfTheSameBodiesAmongMany)
{
    for (std::size_t kind = 0; kind < kinds; ++kind)
        for (std::uint64_t count = 1; count <= 4; ++count) {
            World few, many;
            for (World* const world : {&few, &many}) {
                for (std::uint64_t i = 0; i < count; ++i)
                    world->bodies().add({.model = world->models().add(std::make_shared<const Geometry>(
                                             Geometry{"", draw_geometry(i == 0 ? kind : std::size_t(i), i), ""})),
                                         .pose = random_pose(i, 1),
                                         .layer = std::uint32_t(1 + i % 2)});
                if (count > 2) world->bodies().remove(world->bodies().at(1));
            }
            const ModelId ball = many.models().add(Shape(Sphere{0.1}));
            for (int i = 0; i < 10; ++i)
                many.bodies().add({.model = ball, .pose = Eigen::Isometry3d(Eigen::Translation3d(100 + i, 50, 0))});
            std::size_t hits = 0;
            for (std::uint64_t k = 0; k < 200; ++k) {
                const Segment segment = draw(k);
                const CollisionFilter filter{.mask = k % 4 ? 3u : 1u};
                const std::optional<CastHit> a = few.space().cast(segment, filter);
                std::optional<CastHit> b = many.space().cast(segment, filter);
                ASSERT_EQ(a.has_value(), b.has_value()) << kind << " " << count << " " << k;
                if (a) {
                    ASSERT_EQ(a->body.slot, b->body.slot);
                    b->body = a->body; // ids name their World, too
                    expect_same(*a, *b), ++hits;
                }
                const auto in_few = few.space().overlaps(segment, filter),
                           in_many = many.space().overlaps(segment, filter);
                ASSERT_EQ(in_few.size(), in_many.size()) << kind << " " << count << " " << k;
                for (std::size_t i = 0; i < in_few.size(); ++i) EXPECT_EQ(in_few[i].body.slot, in_many[i].body.slot);
            }
            EXPECT_GT(hits, 0u) << kind << " " << count;
        }
}

} // namespace
} // namespace oncollide::casts_test
