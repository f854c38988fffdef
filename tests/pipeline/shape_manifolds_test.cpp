// Manifolds of shapes against closed forms and extended precision, and the judge itself.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "truth/convex_truth.hpp"
#include "verify/cases/placed_body.hpp"
#include "verify/oracle/shape_truth.hpp"
#include "verify/oracle/solid_gap.hpp"
#include "verify/trials/shape_manifold_trial.hpp"

namespace oncollide {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using oracle::LongVector;
using oracle::ShapeClaim;
using oracle::SolidTruth;

Isometry3d moved(double x, double y, double z)
{
    return Isometry3d(Eigen::Translation3d(x, y, z));
}

/// Many pairs of all kinds, at poses that are hard for contacts.
TEST(ShapeManifolds, KeepTheirPromises)
{
    const tools::ShapeManifoldTally tally = tools::try_shape_manifolds(1, 5000, 2, [] {});
    const tools::ShapeManifoldTally::Counts all = tally.all();
    for (const auto& fault : all.faults) ADD_FAILURE() << fault.seed << ": " << fault.what;
    EXPECT_EQ(all.pairs, 5000u);
    EXPECT_GT(tally.by_kinds.at(tools::kinds_of("box,terrain")).meet, 20u);
    EXPECT_GT(tally.by_kinds.at(tools::kinds_of("hull,mesh")).meet, 20u);
    EXPECT_GT(all.meet, 2500u);
    EXPECT_GT(all.near, 200u);
}

/// Seeds of which a claim was once wrong.
TEST(ShapeManifolds, KeepTheirPromisesWhereTheyWereHard)
{
    const std::pair<const char*, std::uint64_t> hard[] = {
        {"box,cylinder", 7073},      // polytope that folds over in a plane
        {"capsule,cone", 7628},      // needle beside a body of ten kilometres
        {"capsule,cone", 28236},     //
        {"sphere,map", 27029},       // flat difference, apart by 6e-12
        {"sphere,map", 50269},       //
        {"capsule,map", 93784},      //
        {"capsule,mesh", 59398},     //
        {"capsule,terrain", 268839}, //
        {"capsule,box", 31481},      // search that ended before its last direction
        {"hull,ellipsoid", 96232},   // any direction of a gap
        {"sphere,map", 1000670},     // ball in a cell whose middle is in the ball
        {"capsule,map", 1003792},    // capsule between cells without an open side
        {"ellipsoid,map", 1002486},  //
        {"box,map", 1002960},        // measures, apart by 2e-11
        {"hull,ellipsoid", 190},     // polytope with corners near each other
        {"hull,ellipsoid", 6926},    //
        {"hull,cone", 431},          // depth far below the sizes
        {"hull,cone", 16234},        //
        {"box,box", 546351},         // gap that edges show, beside a face that is preferred
        {"box,box", 945407},         //
        {"box,box", 211919},         // the same, overlapping
        {"box,box", 92454},          // edges so nearly parallel that their sine's square is lost
        {"capsule,mesh", 143734},    // distance far below the corners' sizes
        {"capsule,terrain", 325567}, //
        {"capsule,box", 1118105},    // the same from a point to an edge
        {"sphere,box", 1660962},     //
        {"capsule,cone", 179156},    // polytope that folds where sizes are far apart
        {"cylinder,cone", 323875},   //
        {"hull,cone", 554871},       //
        {"cone,ellipsoid", 899839},  //
        {"hull,cylinder", 971902},   //
        {"box,mesh", 267217},        // corner inside by a rounding
        {"box,mesh", 229054},        //
        {"box,terrain", 320491},     //
        {"box,terrain", 352248},     //
        {"capsule,hull", 121958},    // segment shorter than rounding
        {"box,map", 534594},         // wall that is aside
        {"box,map", 677680},         // cells far from the origin, within the margin by 1e-11
        {"hull,map", 654122},        //
        {"box,terrain", 309341},     // point beside a face by 1e-9
        {"box,terrain", 844746},     // point of the ground that faces no face of the box
        {"cone,half-space", 584000}, // small face far from the origin
    };
    for (const auto& [kinds, seed] : hard) {
        const tools::ShapeManifoldTally tally = tools::try_shape_manifolds(
            seed, 1, 1, [] {}, tools::kinds_of(kinds));
        for (const auto& fault : tally.all().faults) ADD_FAILURE() << seed << ": " << fault.what;
    }
}

ManifoldPoint point(const Vector3d& on_a, const Vector3d& on_b, double depth, const Vector3d& normal)
{
    return {on_a, on_b, depth, 0, 0, 0, normal};
}
ManifoldRegion region(RegionKind kind, const Vector3d& normal, double depth, std::uint32_t count)
{
    return {kind, false, normal, 0, 0, 0, Vector3d::Zero(), depth, depth, 0, 0, count, count};
}
Manifold swapped(Manifold m)
{
    for (ManifoldRegion& r : m.regions) r.normal = -r.normal;
    for (ManifoldPoint& p : m.points)
        std::swap(p.point_a, p.point_b), std::swap(p.feature_a, p.feature_b), p.normal = -p.normal;
    return m;
}

/// A pair with its right manifold, which a test makes false.
struct RightManifold {
    SolidTruth a, b;
    Verdict verdict;
    ManifoldOptions options;
    Manifold manifold;

    std::vector<ShapeClaim> faults(const std::function<void(Manifold&)>& change) const
    {
        Manifold wrong = manifold;
        change(wrong);
        return faults(wrong, swapped(wrong), options);
    }
    std::vector<ShapeClaim> faults(const Manifold& there, const Manifold& back, const ManifoldOptions& of) const
    {
        std::vector<ShapeClaim> claims;
        for (const oracle::ShapeFault& fault : oracle::judge_shapes(a, b, {verdict, there, back, of}).faults)
            claims.push_back(fault.claim);
        return claims;
    }
    /// Expects the claim among the faults that a change makes.
    void rejects(ShapeClaim claim, const std::function<void(Manifold&)>& change) const
    {
        const std::vector<ShapeClaim> found = faults(change);
        EXPECT_NE(std::ranges::find(found, claim), found.end())
            << oracle::shape_claims[static_cast<int>(claim)] << ", " << found.size() << " others";
    }
};

/// A small box stands on a large one and is 0.125 deep.
RightManifold box_on_box()
{
    const Vector3d up(0, 0, 1), origin(0, 0, 0);
    RightManifold right{SolidTruth(Box{{1, 1, 1}}, moved(0, 0, 0), origin),
                        SolidTruth(Box{{0.5, 0.5, 0.5}}, moved(0.125, 0.25, 1.375), origin),
                        Verdict::colliding,
                        {},
                        {}};
    for (const double x : {-0.375, 0.625})
        for (const double y : {-0.25, 0.75})
            right.manifold.points.push_back(point({x, y, 1}, {x, y, 0.875}, 0.125, up));
    right.manifold.regions.push_back(region(RegionKind::crossing, up, 0.125, 4));
    return right;
}

/// A capsule stands 0.25 beside a sphere.
RightManifold capsule_near_sphere()
{
    const Vector3d along(1, 0, 0), origin(0, 0, 0);
    RightManifold right{SolidTruth(Sphere{1}, moved(0, 0, 0), origin),
                        SolidTruth(Capsule{0.5, 1}, moved(1.75, 0, 0.25), origin),
                        Verdict::separate,
                        {.margin = 0.5},
                        {}};
    right.manifold.points.push_back(point({1, 0, 0}, {1.25, 0, 0}, -0.25, along));
    right.manifold.regions.push_back(region(RegionKind::near, along, -0.25, 1));
    return right;
}

/// A rim's polygon of eight points leaves out a sliver of the round face. Contacts there are as exact as others, on a
/// shape, a mesh and the cells of a map.
TEST(ShapeManifolds, HavePointsWhereOnlyTheSliverOfARimIsOverAFace)
{
    const Isometry3d turned(Eigen::AngleAxisd(std::numbers::pi / 8, Vector3d::UnitZ()));
    const GeometryData grounds[] = {Shape(Box{{1, 1, 1}}), make_box_mesh({1, 1, 1}),
                                    make_occupancy_map("map", 2, std::vector<MapCell>{{0, 0, 0, 1}})};
    for (const GeometryData& ground : grounds)
        for (const Shape& shape : {Shape(Cylinder{1, 1}), Shape(Cone{1, 1})})
            for (const double depth : {1e-3, 1e-9, 0.0}) {
                World world({.mode = Mode::solid});
                const bool map = std::holds_alternative<OccupancyMap>(ground);
                const Isometry3d pose_a = map ? moved(-1, -1, -1) : moved(0, 0, 0),
                                 pose_b = moved(1.95, 0, 1.5 - depth) * turned;
                const BodyId a = world.bodies().add({.model = tools::add_model(world, ground), .pose = pose_a}),
                             b = world.bodies().add({.model = tools::add_model(world, shape), .pose = pose_b});
                const Manifold found = world.pairs().manifold(a, b);
                SCOPED_TRACE(fmt::format("ground {}, shape {}, depth {}", ground.index(), shape.index(), depth));
                ASSERT_FALSE(found.points.empty());
                const SolidTruth solid(shape, pose_b, Vector3d::Zero());
                for (const ManifoldPoint& p : found.points) {
                    EXPECT_LT(p.depth_error, 1e-6);
                    EXPECT_NEAR(p.depth, depth, 1e-6);
                    EXPECT_NEAR(double(solid.from_surface(p.point_b.cast<long double>())), 0, 1e-6);
                    EXPECT_NEAR(p.point_a.z(), 1, 1e-6);
                    EXPECT_LE(p.point_a.x(), 1 + 1e-6);
                }
            }
}

TEST(ShapeManifolds, TheJudgeRejectsFalseClaimsOfSolidsThatMeet)
{
    const RightManifold right = box_on_box();
    const auto nothing = [](Manifold&) {};
    EXPECT_TRUE(right.faults(nothing).empty());
    right.rejects(ShapeClaim::presence, [](Manifold& m) { m = {}; });
    right.rejects(ShapeClaim::one_region, [](Manifold& m) { m.regions.push_back(m.regions[0]); });
    right.rejects(ShapeClaim::one_region, [](Manifold& m) { m.regions[0].count = 0; });
    right.rejects(ShapeClaim::one_region, [](Manifold& m) {
        m.points.push_back(point({0, 0, 1}, {0, 0, 0.875}, 0.125, {0, 0, 1})), m.regions[0].count = 5;
    });
    right.rejects(ShapeClaim::normal, [](Manifold& m) { m.regions[0].normal *= 1 + 1e-12; });
    right.rejects(ShapeClaim::normal, [](Manifold& m) { m.points[2].normal = {1, 0, 0}; });
    right.rejects(ShapeClaim::depth_upper, [](Manifold& m) { m.regions[0].depth_upper -= 1e-10; });
    right.rejects(ShapeClaim::depth_upper, [](Manifold& m) { m.regions[0].normal *= -1; });
    right.rejects(ShapeClaim::depth_upper,
                  [](Manifold& m) { m.regions[0].normal = Vector3d(1e-9, 0, 1).normalized(); });
    right.rejects(ShapeClaim::tight_upper, [](Manifold& m) { m.regions[0].depth_upper += 1e-8; });
    right.rejects(ShapeClaim::depth_lower,
                  [](Manifold& m) { m.regions[0].depth_lower = m.regions[0].depth_upper += 1e-10; });
    right.rejects(ShapeClaim::least, [](Manifold& m) {
        m.regions[0].normal = {1, 0, 0}, m.regions[0].depth_upper = m.regions[0].depth_lower = 1.375;
    });
    right.rejects(ShapeClaim::surface, [](Manifold& m) { m.points[1].point_a.z() += 1e-10; });
    right.rejects(ShapeClaim::surface, [](Manifold& m) { m.points[3].point_b.z() -= 1e-10; });
    right.rejects(ShapeClaim::offset, [](Manifold& m) { m.points[0].point_b.x() += 1e-10; });
    right.rejects(ShapeClaim::depth, [](Manifold& m) { m.points[0].depth = 0.126; });
    right.rejects(ShapeClaim::depth, [](Manifold& m) { m.points[0].depth_error = -1; });
    right.rejects(ShapeClaim::repeated, [](Manifold& m) { m.points[1] = m.points[0]; });
    Manifold other = swapped(right.manifold);
    other.points[0].depth = std::nextafter(0.125, 1);
    EXPECT_EQ(right.faults(right.manifold, other, right.options), std::vector{ShapeClaim::swapped});
}

TEST(ShapeManifolds, TheJudgeRejectsFalseClaimsOfSolidsThatAreNear)
{
    const RightManifold right = capsule_near_sphere();
    const auto nothing = [](Manifold&) {};
    EXPECT_TRUE(right.faults(nothing).empty());
    right.rejects(ShapeClaim::presence, [](Manifold& m) { m = {}; });
    EXPECT_EQ(right.faults(right.manifold, swapped(right.manifold), {.margin = 0.25 - 1e-10}),
              std::vector{ShapeClaim::presence});
    EXPECT_TRUE(right.faults({}, {}, {.margin = 0.25 - 1e-10}).empty());
    right.rejects(ShapeClaim::kind, [](Manifold& m) { m.regions[0].kind = RegionKind::touching; });
    right.rejects(ShapeClaim::normal_error,
                  [](Manifold& m) { m.regions[0].normal = Vector3d(1, 1e-8, 0).normalized(); });
    right.rejects(ShapeClaim::depth_upper,
                  [](Manifold& m) { m.regions[0].depth_upper = m.regions[0].depth_lower -= 1e-10; });
    right.rejects(ShapeClaim::depth_lower,
                  [](Manifold& m) { m.regions[0].depth_lower = m.regions[0].depth_upper += 1e-10; });
    right.rejects(ShapeClaim::least, [](Manifold& m) { m.regions[0].depth_upper += 0.01; });
    right.rejects(ShapeClaim::surface, [](Manifold& m) { m.points[0].point_b.y() += 1e-4; });
}

/// Distances and depths of points against a search that knows only the support function.
TEST(ShapeManifolds, TheReferenceKnowsTheSurfacesOfAllKinds)
{
    int inside = 0;
    for (int kind = 0; kind < 7; ++kind)
        for (std::uint64_t seed = 0; seed < 60; ++seed) {
            const tools::ShapePair pair =
                tools::draw_shape_pair(tools::ShapeKind(kind), tools::ShapeKind::sphere, seed);
            const SolidTruth solid(pair.a, pair.pose_a, pair.pose_a.translation());
            const long double size = solid.size();
            const LongVector from = solid.centre(), to = solid.core_support({0.3L, -0.4L, 0.5L});
            const LongVector at = from + (0.1L * (seed % 20)) * (to - from);
            const long double distance = solid.from_surface(at);
            const std::string where = fmt::format("{}, seed {}", tools::shape_kinds[kind], seed);
            if (distance > 0) {
                const oracle::SolidGap gap = oracle::gap_to(solid, at);
                EXPECT_LE(double((gap.lower - distance) / size), 1e-15) << where;
                EXPECT_LE(double((distance - gap.upper) / size), 1e-15) << where;
                EXPECT_LE(double((gap.upper - gap.lower) / size), 1e-10) << where;
                continue;
            }
            ++inside;
            long double least = size;
            const auto try_along = [&](const LongVector& n) {
                least = std::min(least, solid.height(n.normalized()) - n.normalized().dot(at));
            };
            for (const LongVector& n : solid.faces()) try_along(n), try_along(-n);
            for (int k = 0; k < 400; ++k) {
                const double z = (2 * k + 1) / 400.0 - 1, turn = 2.4 * k;
                try_along({std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z});
            }
            EXPECT_GE(double((least + distance) / size), -1e-15) << where;
            EXPECT_LE(double((least + distance) / size), 0.02) << where;
        }
    EXPECT_GT(inside, 100);
}

/// The distance of two solids against another implementation.
TEST(ShapeManifolds, TheReferenceAgreesWithAnotherOnDistances)
{
    int apart = 0, wide = 0;
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
        const auto kind = [&](std::uint64_t k) { return tools::ShapeKind(k % 7); };
        const tools::ShapePair pair = tools::draw_shape_pair(kind(seed), kind(seed / 7), seed);
        const Vector3d origin = pair.pose_a.translation();
        const auto local = [&](Isometry3d pose) {
            pose.translation() -= origin;
            return pose;
        };
        const SolidTruth a(pair.a, pair.pose_a, origin), b(pair.b, pair.pose_b, origin);
        const oracle::SolidGap gap = oracle::gap_of(a, b);
        const tools::TrueDistance other = tools::true_distance(tools::convex_sets(pair.a, local(pair.pose_a)),
                                                               tools::convex_sets(pair.b, local(pair.pose_b)));
        const double scale = double(a.size() + b.size() + (b.centre() - a.centre()).norm());
        EXPECT_LE(double(gap.lower - other.upper), 1e-15 * scale) << seed;
        EXPECT_LE(double(other.lower - gap.upper), 1e-15 * scale) << seed;
        EXPECT_LE(double(gap.upper - gap.lower), 1e-9 * scale) << seed;
        wide += gap.upper - gap.lower > 1e-13 * scale;
        apart += gap.lower > 1e-12 * scale;
    }
    EXPECT_GT(apart, 200);
    EXPECT_LT(wide, 10);
}

TEST(ShapeManifolds, OfOneSeedIsTheSameCaseAmongAllKindsAndAlone)
{
    const auto of = [](const tools::ShapeManifoldTally& tally) {
        const auto counts = tally.all();
        return std::array{counts.pairs, counts.meet, counts.near, counts.regions, counts.points};
    };
    for (const std::uint64_t seed : {1u, 17u, 48u}) {
        const tools::ShapeManifoldTally among = tools::try_shape_manifolds(seed, 1, 1, [] {});
        ASSERT_EQ(among.by_kinds.size(), 1u);
        EXPECT_EQ(of(among), of(tools::try_shape_manifolds(
                                 seed, 1, 1, [] {}, among.by_kinds.begin()->first)));
    }
    EXPECT_EQ(tools::name_of_kinds(tools::kinds_of("box,sphere")), "sphere box");
    for (const char* wrong : {"box", "box,ball", "half-space,half-space", "half-space,mesh", "mesh,terrain"})
        EXPECT_THROW((void)tools::kinds_of(wrong), Error) << wrong;
}

} // namespace
} // namespace oncollide
