// Terrains against every kind: the verdicts equal the verdicts for the same surface as a mesh, and bounds hold for
// heights with errors.
#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/geometry.hpp>

#include "random_pose.hpp"

namespace oncollide::terrain_test {
namespace {

using Eigen::Isometry3d;

/// Steep random heights, integers times `unit`, with holes.
Terrain rough(std::uint32_t columns, std::uint32_t rows, double unit, double holes, std::uint64_t seed, int bytes = 0)
{
    TerrainGrid grid{.columns = columns, .rows = rows};
    grid.spacing = {0.5, 0.75}, grid.origin = {-3, -2, 0.25};
    grid.no_data = -9999, grid.bytes = bytes;
    std::vector<double> heights;
    for (std::uint64_t i = 0; i < std::uint64_t(columns) * rows; ++i)
        heights.push_back(u01(seed, i, 1) < holes ? -9999 : unit * std::floor(6 * u01(seed, i, 0)));
    for (std::uint64_t i = 0; i < std::uint64_t(columns - 1) * (rows - 1); ++i)
        grid.falling.push_back(u01(seed, i, 2) < 0.5);
    return make_terrain("rough", grid, heights);
}

std::vector<GeometryData> bodies()
{
    ConvexHull hull;
    for (std::uint64_t i = 0; i < 12; ++i)
        hull.points.push_back(Eigen::Vector3d(u01(7, i, 0) - 0.5, u01(7, i, 1) - 0.5, u01(7, i, 2) - 0.5));
    return {make_torus_knot_mesh(2, 3, 0.5, 0.2, 0.08, 400),
            make_box_mesh({0.25, 0.5, 0.25}),
            Shape(Sphere{0.375}),
            Shape(Box{{0.25, 0.5, 0.25}}),
            Shape(Capsule{0.25, 0.5}),
            Shape(Cylinder{0.25, 0.5}),
            Shape(hull),
            make_building_map(1, 0.5, 3),
            rough(9, 5, 0.25, 0.1, 5)};
}

struct Pair {
    World world;
    BodyId first, second;
};

Pair pair_of(const Settings& settings, const GeometryData& a, const Isometry3d& pose_a, const GeometryData& b,
             const Isometry3d& pose_b)
{
    Pair pair{World(settings), {}, {}};
    const auto add = [&](const GeometryData& geometry, const Isometry3d& pose) {
        const ModelId model = std::visit([&](const auto& g) { return pair.world.models().add(g); }, geometry);
        return pair.world.bodies().add({.model = model, .pose = pose});
    };
    pair.first = add(a, pose_a), pair.second = add(b, pose_b);
    return pair;
}

PairResult result_of(World& world)
{
    const FrameView frame = world.step();
    PairResult apart{{Verdict::separate, ContactKind::unknown, 0}, StageId::bounds, {}, {}};
    apart.verdict = Verdict::separate;
    return frame.pairs.empty() ? apart : frame.pairs[0];
}

/// For shapes: on a grid of 1/8, so that touching is common, or anywhere.
Isometry3d drawn_pose(std::uint64_t seed, bool on_grid)
{
    Isometry3d pose = on_grid ? Isometry3d::Identity() : random_pose(seed, 1);
    for (std::uint64_t k = 0; k < 3; ++k) {
        const double at = (k == 2 ? 1.5 : 3) * (2 * u01(seed, 3, k) - 1);
        pose.translation()[int(k)] = on_grid ? std::floor(8 * at) / 8 : at;
    }
    return pose;
}

void expect_same(const Settings& settings, const Terrain& terrain, const GeometryData& other, bool terrain_first,
                 bool on_grid, std::uint64_t seed, std::array<int, 4>& verdicts)
{
    const Mesh mesh = mesh_of(terrain);
    const Isometry3d mine = on_grid ? Isometry3d::Identity() : random_pose(seed + 77, 0.2),
                     pose = mine * drawn_pose(seed, on_grid);
    const auto pair = [&](const GeometryData& surface) {
        return terrain_first ? pair_of(settings, surface, mine, other, pose)
                             : pair_of(settings, other, pose, surface, mine);
    };
    Pair as_terrain = pair(terrain), as_mesh = pair(mesh);
    const PairResult found = result_of(as_terrain.world), truth = result_of(as_mesh.world);
    ++verdicts[std::size_t(found.verdict)];
    EXPECT_EQ(int(found.verdict), int(truth.verdict)) << seed << " kind " << other.index();
    EXPECT_EQ(int(found.kind), int(truth.kind)) << seed << " kind " << other.index();
    if (std::holds_alternative<OccupancyMap>(other)) return; // has no distances
    const Distance near = as_terrain.world.pairs().distance(as_terrain.first, as_terrain.second),
                   far = as_mesh.world.pairs().distance(as_mesh.first, as_mesh.second);
    EXPECT_NEAR(near.lower, far.lower, 1e-9) << seed;
    EXPECT_NEAR(near.upper, far.upper, 1e-9) << seed;
    if (found.verdict == Verdict::separate) {
        EXPECT_LE(found.bound, far.upper) << seed;
    }
    if (found.verdict == Verdict::within) {
        EXPECT_GE(found.bound, far.lower) << seed;
    }
}

TEST(Terrain, HasTheVerdictsOfTheSameSurfaceAsAMesh)
{
    const std::vector<Settings> settings = {
        {.exact = ExactLevel::predicates, .threads = 1},
        {.exact = ExactLevel::predicates, .contact_kinds = true, .threads = 1},
        {.exact = ExactLevel::predicates, .ignore_touching = true, .threads = 1},
        {.clearance = 0.25, .exact = ExactLevel::predicates, .threads = 1},
        {.exact = ExactLevel::predicates, .bounding_volume = BoundingVolume::sphere, .threads = 1},
    };
    std::array<int, 4> verdicts{};
    std::uint64_t seed = 0;
    for (const GeometryData& other : bodies())
        for (const Settings& s : settings)
            for (const bool on_grid : {true, false})
                for (int i = 0; i < 12; ++i, ++seed)
                    expect_same(s, rough(13, 9, on_grid ? 0.25 : 0.3, i % 2 ? 0.1 : 0, seed), other, i % 3 != 0,
                                on_grid, seed, verdicts);
    EXPECT_GT(verdicts[std::size_t(Verdict::separate)], 100);
    EXPECT_GT(verdicts[std::size_t(Verdict::colliding)], 100);
}

/// Pairs that are reported separate within an error are separate.
TEST(Terrain, IsWithinTheErrorOrSeparate)
{
    for (const GeometryData& other : bodies()) {
        if (std::holds_alternative<OccupancyMap>(other)) continue;
        for (std::uint64_t seed = 0; seed < 40; ++seed) {
            const Terrain terrain = rough(13, 9, 0.3, 0.1, seed);
            Pair pair = pair_of({.max_error = 0.05, .clearance = 0.1}, terrain, Isometry3d::Identity(), other,
                                drawn_pose(seed, false));
            const PairResult found = result_of(pair.world);
            const Distance distance = pair.world.pairs().distance(pair.first, pair.second);
            if (found.verdict == Verdict::separate) {
                EXPECT_GT(distance.upper, 0.1);
                EXPECT_LE(found.bound, distance.upper + 1e-12);
            } else {
                EXPECT_EQ(found.verdict, Verdict::within);
                EXPECT_LE(distance.lower, found.bound);
                EXPECT_LE(found.bound, 0.16);
            }
        }
    }
}

/// At one byte, heights of a wide range have errors; the truth is the given surface.
TEST(Terrain, WithHeightsThatAreOffIsNeverSureWithinTheirError)
{
    int separate = 0, within = 0;
    std::uint64_t seed = 0;
    for (const GeometryData& other : bodies()) {
        if (std::holds_alternative<OccupancyMap>(other) || std::holds_alternative<Terrain>(other)) continue;
        for (int i = 0; i < 60; ++i, ++seed) {
            const Terrain given = rough(13, 9, 0.3 + 1e-3 * u01(seed, 1, 1), 0.1, seed);
            TerrainGrid grid{.columns = 13, .rows = 9};
            grid.spacing = given.spacing(), grid.origin = given.origin(), grid.bytes = 1;
            grid.no_data = std::numeric_limits<double>::quiet_NaN();
            std::vector<double> heights;
            for (std::uint32_t r = 0; r < 9; ++r)
                for (std::uint32_t c = 0; c < 13; ++c) heights.push_back(given.height(c, r));
            for (std::uint32_t y = 0; y < 8; ++y)
                for (std::uint32_t x = 0; x < 12; ++x)
                    grid.falling.push_back(given.diagonal(x, y) == CellDiagonal::falling);
            const Terrain kept = make_terrain("kept", grid, heights);
            ASSERT_GT(kept.error(), 1e-4);
            ASSERT_LT(kept.error(), 0.01);
            const Isometry3d pose = drawn_pose(seed, false), stay = Isometry3d::Identity();
            Pair off = pair_of({.exact = ExactLevel::predicates}, kept, stay, other, pose),
                 exact = pair_of({.exact = ExactLevel::predicates}, given, stay, other, pose);
            const PairResult found = result_of(off.world), truth = result_of(exact.world);
            const Distance distance = exact.world.pairs().distance(exact.first, exact.second),
                           bounds = off.world.pairs().distance(off.first, off.second);
            EXPECT_LE(bounds.lower, distance.upper);
            EXPECT_GE(bounds.upper, distance.lower);
            if (found.verdict == Verdict::separate) {
                ++separate;
                EXPECT_EQ(truth.verdict, Verdict::separate) << seed;
                EXPECT_LE(found.bound, distance.upper) << seed;
            } else if (found.kind != ContactKind::enclosed) {
                ++within;
                EXPECT_EQ(found.verdict, Verdict::within) << seed;
                EXPECT_LE(distance.lower, found.bound) << seed;
                EXPECT_LE(found.bound, 0.03) << seed;
            }
        }
    }
    EXPECT_GT(separate, 50);
    EXPECT_GT(within, 50);
}

/// No shape is involved, so neither body can contain a part of the other.
TEST(Terrain, WithHeightsThatAreOffIsApartFromALargeMeshAboveIt)
{
    TerrainGrid grid{.columns = 3, .rows = 3};
    grid.spacing = {5, 5}, grid.origin = {-5, -5, 0}, grid.bytes = 1;
    const Terrain valley = make_terrain("valley", grid, std::vector<double>{2, 2, 2, 0, 0.123456, 0, 2, 2, 2});
    ASSERT_GT(valley.error(), 0);
    Isometry3d pose(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()));
    pose.translation().z() = 2;
    const GeometryData roof = make_terrain_mesh(4, 0.1, 300, 1);
    Pair pair = pair_of({.exact = ExactLevel::predicates}, valley, Isometry3d::Identity(), roof, pose);
    const PairResult found = result_of(pair.world);
    EXPECT_EQ(found.verdict, Verdict::separate);
    EXPECT_GT(found.bound, 0);
}

/// An island in a large box: no surfaces meet.
TEST(Terrain, PartsInsideASolidCollide)
{
    TerrainGrid grid{.columns = 9, .rows = 9};
    grid.no_data = -1;
    std::vector<double> heights(81, -1.0);
    for (const auto& [x, y] : {std::pair(1, 1), std::pair(6, 6)})
        for (const int at : {y * 9 + x, y * 9 + x + 1, (y + 1) * 9 + x, (y + 1) * 9 + x + 1})
            heights[std::size_t(at)] = 0.5;
    const Terrain islands = make_terrain("islands", grid, heights);
    EXPECT_EQ(islands.cells(), 2u);
    const Isometry3d stay = Isometry3d::Identity(), over_one = Isometry3d(Eigen::Translation3d(6.5, 6.5, 0.5)),
                     between = Isometry3d(Eigen::Translation3d(4, 4, 0.5));
    const GeometryData mesh = make_box_mesh({1, 1, 1}), box = Shape(Box{{1, 1, 1}}), ball = Shape(Sphere{1.5});
    const Settings surface{.exact = ExactLevel::predicates},
        solid{.exact = ExactLevel::predicates, .mode = Mode::solid};
    const auto verdict = [&](const Settings& s, const GeometryData& other, const Isometry3d& pose, bool first) {
        Pair pair = first ? pair_of(s, islands, stay, other, pose) : pair_of(s, other, pose, islands, stay);
        return result_of(pair.world).verdict;
    };
    for (const bool first : {true, false}) {
        EXPECT_EQ(verdict(surface, mesh, over_one, first), Verdict::separate);
        EXPECT_EQ(verdict(solid, mesh, over_one, first), Verdict::colliding);
        EXPECT_EQ(verdict(solid, mesh, between, first), Verdict::separate);
        for (const GeometryData& shape : {box, ball}) {
            EXPECT_EQ(verdict(surface, shape, over_one, first), Verdict::colliding);
            EXPECT_EQ(verdict(surface, shape, between, first), Verdict::separate);
        }
    }
}

TEST(Terrain, ContactsAreThoseOfTheMesh)
{
    const GeometryData knot = bodies()[0];
    int found = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        const Terrain terrain = rough(13, 9, 0.3, 0, seed);
        const Mesh mesh = mesh_of(terrain);
        const Isometry3d stay = Isometry3d::Identity(), pose = drawn_pose(seed, false);
        Pair as_terrain = pair_of({}, terrain, stay, knot, pose), as_mesh = pair_of({}, mesh, stay, knot, pose);
        const auto contacts = as_terrain.world.pairs().contacts(as_terrain.first, as_terrain.second),
                   truth = as_mesh.world.pairs().contacts(as_mesh.first, as_mesh.second);
        ASSERT_EQ(contacts.size(), truth.size());
        for (std::size_t i = 0; i < contacts.size(); ++i, ++found) {
            EXPECT_EQ(contacts[i].a.triangle, truth[i].a.triangle);
            EXPECT_EQ(contacts[i].b.triangle, truth[i].b.triangle);
            EXPECT_EQ(contacts[i].ends[0], truth[i].ends[0]);
            EXPECT_EQ(contacts[i].normal_a, truth[i].normal_a);
        }
    }
    EXPECT_GT(found, 100);
}

} // namespace
} // namespace oncollide::terrain_test
