// Distances and nearest points of every pair of kinds of geometry, compared with the distance of convex sets in
// extended precision, which shares no code with the library.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/pipeline/world.hpp>

#include "every_kind.hpp"
#include "random_pose.hpp"
#include "truth/convex_truth.hpp"

namespace oncollide {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// A body as the oracle sees it.
struct Placed {
    GeometryData geometry;
    Isometry3d pose;
    bool half_space;
    std::vector<tools::ConvexSet> sets;

    Placed(GeometryData what, const Isometry3d& at)
        : geometry(std::move(what)), pose(at), sets(tools::convex_sets(geometry, pose))
    {
        const auto* shape = std::get_if<Shape>(&geometry);
        half_space = shape && std::holds_alternative<HalfSpace>(*shape);
    }
    double off(const Vector3d& point) const
    {
        const auto* shape = std::get_if<Shape>(&geometry);
        // Extended precision converges slowly to a rim: it may have an error of 2e-7.
        if (const auto* c = shape ? std::get_if<Cylinder>(shape) : nullptr) {
            const Vector3d p = pose.inverse() * point;
            const double across = std::hypot(p.x(), p.y()) - c->radius, along = std::abs(p.z()) - c->length / 2;
            return std::hypot(std::max(across, 0.0), std::max(along, 0.0));
        }
        const std::vector<tools::ConvexSet> there{
            [p = tools::ExtendedVector(point.cast<long double>())](const tools::ExtendedVector&) { return p; }};
        return double(half_space ? tools::half_space_distance(pose, there).upper
                                 : tools::true_distance(sets, there).upper);
    }
};

tools::TrueDistance truth_of(const Placed& a, const Placed& b)
{
    if (a.half_space && b.half_space) return tools::half_spaces_distance(a.pose, b.pose);
    if (a.half_space) return tools::half_space_distance(a.pose, b.sets);
    if (b.half_space) return tools::half_space_distance(b.pose, a.sets);
    return tools::true_distance(a.sets, b.sets);
}

struct Pair {
    World world;
    BodyId a, b;
};

Pair world_of(const Placed& a, const Placed& b)
{
    Pair pair{World({.exact = ExactLevel::predicates}), {}, {}};
    const auto add = [&](const Placed& body) {
        const ModelId model = std::visit([&](const auto& g) { return pair.world.models().add(g); }, body.geometry);
        return pair.world.bodies().add({.model = model, .pose = body.pose});
    };
    pair.a = add(a), pair.b = add(b);
    return pair;
}

/// The poses of a case: on a grid, where touching is common; randomly rotated, and near; or far apart.
Isometry3d drawn_pose(std::uint64_t seed, int way)
{
    Isometry3d pose = way == 0 ? Isometry3d::Identity() : random_pose(seed, 1);
    for (std::uint64_t k = 0; k < 3; ++k) {
        const double at = (way == 2 ? 30 : 2.5) * (2 * u01(seed, 3, k) - 1);
        pose.translation()[int(k)] = way == 0 ? std::floor(8 * at) / 8 : at;
    }
    return pose;
}

struct Seen {
    int apart = 0, meet = 0;
};

void expect_certified(const Placed& a, const Placed& b, double tolerance, double tie, Seen& seen)
{
    Pair pair = world_of(a, b);
    const tools::TrueDistance truth = truth_of(a, b);
    const Distance d = pair.world.pairs().distance(pair.a, pair.b, {.tolerance = tolerance});
    EXPECT_LE(d.lower, truth.upper + tie);
    EXPECT_GE(d.upper, truth.lower - tie);
    EXPECT_GE(d.lower, 0);
    EXPECT_LE(d.upper - d.lower, tolerance + 1e-8 + 1e-6 * d.upper);
    // Points are on the surfaces up to the rounding of the frames and of curved shapes.
    const double on = 1e-7 + tie;
    EXPECT_LE(a.off(d.point_a), on) << "point of a " << d.point_a.transpose();
    EXPECT_LE(b.off(d.point_b), on) << "point of b " << d.point_b.transpose();
    EXPECT_NEAR((d.point_a - d.point_b).norm(), d.upper, tolerance + on);
    (truth.upper > 1e-9 ? seen.apart : seen.meet)++;

    const FrameView frame = pair.world.step();
    const Verdict verdict = frame.pairs.empty() ? Verdict::separate : frame.pairs[0].verdict;
    const double bound = frame.pairs.empty() ? 0 : frame.pairs[0].bound;
    if (verdict == Verdict::separate) {
        EXPECT_GT(truth.upper, 0);
        EXPECT_LE(bound, truth.upper + tie);
    } else {
        EXPECT_LE(truth.lower, bound + tie);
        EXPECT_LE(bound, 1e-9);
    }

    // A cutoff below the distance gives a lower bound above the cutoff; a cutoff above the distance changes nothing.
    if (truth.lower < 1e-3) return;
    const Distance cut = pair.world.pairs().distance(pair.a, pair.b, {.cutoff = 0.5 * d.lower});
    EXPECT_GT(cut.lower, 0.5 * d.lower);
    EXPECT_LE(cut.lower, truth.upper + tie);
}

class EveryTwoKinds : public ::testing::TestWithParam<std::size_t> {};

TEST_P(EveryTwoKinds, HaveCertifiedDistancesAndNearestPoints)
{
    const std::size_t kind_a = GetParam() / kinds, kind_b = GetParam() % kinds;
    Seen seen;
    for (std::uint64_t i = 0; i < 24; ++i) {
        const std::uint64_t seed = 1000 * GetParam() + i;
        const int way = int(i % 3);
        const Vector3d far = i % 8 == 7 ? Vector3d(1e5, -1e5, 3e4) : Vector3d::Zero();
        Isometry3d pose_a = way == 0 ? Isometry3d::Identity() : random_pose(seed + 77, 0.5),
                   pose_b = pose_a * drawn_pose(seed, way);
        pose_a.translation() += far, pose_b.translation() += far;
        const Placed a(draw_geometry(kind_a, seed), pose_a), b(draw_geometry(kind_b, seed + 1), pose_b);
        SCOPED_TRACE(fmt::format("{} and {}, case {}", every_kind[kind_a], every_kind[kind_b], i));
        expect_certified(a, b, i % 2 ? 0 : 0.01, 1e-12 + 1e-14 * far.norm(), seen);
    }
    const bool half_space = kind_a + 1 == kinds || kind_b + 1 == kinds;
    EXPECT_GT(seen.apart, half_space && kind_a == kind_b ? -1 : half_space ? 1 : 6);
    EXPECT_GT(seen.meet, half_space ? 2 : -1);
}

INSTANTIATE_TEST_SUITE_P(Distance, EveryTwoKinds, ::testing::Range(std::size_t{0}, kinds* kinds), [](const auto& pair) {
    std::string name = fmt::format("{}_{}", every_kind[pair.param / kinds], every_kind[pair.param % kinds]);
    for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
    return name;
});

/// One inside the other, with no surfaces near.
TEST(Distance, OfSolidsInsideOneAnotherIsZeroAndHasOnePoint)
{
    Seen seen;
    for (const GeometryData& outer :
         {GeometryData(Shape(Box{{9, 9, 9}})), GeometryData(Shape(Sphere{9})), GeometryData(Shape(Cylinder{9, 20})),
          GeometryData(Shape(Capsule{9, 1})), GeometryData(Shape(Ellipsoid{{9, 9, 10}})),
          GeometryData(Shape(Cone{30, 60})), GeometryData(Shape(HalfSpace{}))})
        for (std::size_t kind = 0; kind + 1 < kinds; ++kind)
            for (const bool first : {true, false}) {
                const Isometry3d turn = random_pose(kind, 0), in = Isometry3d(Eigen::Translation3d(0.5, 0.25, -12));
                const auto* shape = std::get_if<Shape>(&outer);
                const bool deep = std::holds_alternative<HalfSpace>(*shape) || std::holds_alternative<Cone>(*shape);
                const Placed around(outer, turn), inner(draw_geometry(kind, kind), deep ? turn * in : turn);
                SCOPED_TRACE(fmt::format("{} in {}, {}", every_kind[kind], shape->index(), first));
                expect_certified(first ? around : inner, first ? inner : around, 0, 1e-12, seen);
            }
    EXPECT_EQ(seen.apart, 0);
}

/// Half-spaces are certainly separate only if they face exactly away from each other.
TEST(Distance, OfHalfSpacesIsThatOfParallelPlanes)
{
    Isometry3d rotated = Isometry3d::Identity();
    rotated.linear().diagonal() << 1, -1, -1;
    Seen seen;
    for (const double gap : {-3.0, -0.5, 0.0, 0x1p-40, 0.25, 1e5})
        for (const bool away : {true, false})
            for (const Isometry3d& frame : {Isometry3d::Identity(), Isometry3d(rotated)}) {
                Isometry3d up = Isometry3d(Eigen::Translation3d(1, 2, gap));
                if (away) up = up * rotated;
                const Placed a(Shape(HalfSpace{}), frame), b(Shape(HalfSpace{}), frame * up);
                SCOPED_TRACE(fmt::format("gap {}, away {}", gap, away));
                expect_certified(a, b, 0, 1e-12, seen), expect_certified(b, a, 0, 1e-12, seen);
            }
    EXPECT_EQ(seen.apart, 2 * 2 * 2);
    const Placed a(Shape(HalfSpace{}), Isometry3d::Identity()), b(Shape(HalfSpace{}), random_pose(1, 5));
    expect_certified(a, b, 0, 1e-12, seen);
}

/// An error of the heights widens the bounds by the same amount, relative to the exact surface.
TEST(Distance, OfTerrainsWithQuantisedHeightsHoldsForTheSurfaceAsGiven)
{
    int cases = 0;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        TerrainGrid grid{.columns = 9, .rows = 9};
        grid.spacing = {0.5, 0.5}, grid.origin = {-2, -2, 0};
        std::vector<double> heights;
        for (std::uint64_t i = 0; i < 81; ++i) heights.push_back(u01(seed, i, 5) * (i % 9 < 4 ? 0.1 : 2));
        grid.bytes = 8;
        const Placed given(make_terrain("given", grid, heights), random_pose(seed, 0.1));
        for (const int bytes : {1, 2, 4}) {
            grid.bytes = bytes;
            const Placed kept(make_terrain("kept", grid, heights), given.pose);
            const double error = std::get<Terrain>(kept.geometry).error();
            EXPECT_GT(error, 0);
            EXPECT_LT(error, 0.01);
            for (std::size_t kind = 0; kind < kinds; ++kind, ++cases) {
                const Placed other(draw_geometry(kind, seed), given.pose * drawn_pose(seed + kind, 1));
                SCOPED_TRACE(fmt::format("{}, seed {}, {} bytes", every_kind[kind], seed, bytes));
                Pair pair = seed % 2 ? world_of(kept, other) : world_of(other, kept);
                const Distance d = pair.world.pairs().distance(pair.a, pair.b);
                const tools::TrueDistance truth = truth_of(given, other);
                EXPECT_LE(d.lower, truth.upper + 1e-12);
                EXPECT_GE(d.upper, truth.lower - 1e-12);
                EXPECT_LE(d.upper - d.lower, 2.1 * error + 1e-8);
            }
        }
    }
    EXPECT_EQ(cases, 60 * 3 * int(kinds));
}

} // namespace
} // namespace oncollide
