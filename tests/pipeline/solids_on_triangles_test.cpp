// Manifolds of boxes, hulls and balls on triangles, which no intersection of surfaces is needed for.
#include <algorithm>

#include <oncollide/base/numbers/random.hpp>

#include "pipeline/manifold_scenes.hpp"

namespace oncollide::manifold_scenes {
namespace {

Isometry3d turned(double x, double y, double z, double yaw)
{
    Isometry3d pose = at(x, y, z);
    pose.linear() = Eigen::AngleAxisd(yaw, Vector3d::UnitZ()).toRotationMatrix();
    return pose;
}

Shape hull_of_box(const Vector3d& half)
{
    ConvexHull hull;
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            for (const double z : {-1.0, 1.0}) hull.points.push_back(half.cwiseProduct(Vector3d(x, y, z)));
    return hull;
}

/// Two slopes that meet along y: a ridge if they rise to the middle, a valley if they fall.
Mesh two_slopes(double rise)
{
    return make_mesh("slopes", {{-5, -5, -rise}, {0, -5, 0}, {5, -5, -rise}, {-5, 5, -rise}, {0, 5, 0}, {5, 5, -rise}},
                     {{0, 1, 3}, {1, 4, 3}, {1, 2, 4}, {2, 5, 4}});
}

/// The manifold of a solid and the ground that has no measures, with the solid as b.
struct OnGround {
    Two two;
    OnGround(const GeometryData& ground, const Shape& solid, const Isometry3d& pose, double top = 0)
        : two(ground, at(0, 0, -top), solid, pose)
    {
    }
    Manifold manifold(double margin = 0) const { return two.world.pairs().manifold(two.a, two.b, {.margin = margin}); }
    Verdict verdict() const { return two.world.pairs().decide(two.a, two.b).verdict; }
    double distance() const { return two.world.pairs().distance(two.a, two.b).lower; }
};

TEST(SolidsOnTriangles, LieOnAPlaneWithItsNormalAndTheirCorners)
{
    const Vector3d half(0.4, 0.3, 0.2);
    for (const Shape& solid : {Shape(Box{half}), hull_of_box(half)})
        for (const auto& [name, make] : grounds) {
            const double top = top_of(name);
            const GeometryData ground = make();
            if (std::holds_alternative<Shape>(ground)) continue;
            for (std::uint64_t k = 0; k < 40; ++k) { // also with corners and edges on edges of the ground
                const double x = k % 4 ? 2 * u01(k, 1, 0) - 1 : 0.5, y = k % 3 ? 2 * u01(k, 2, 0) - 1 : 0.25;
                const Isometry3d pose = turned(x, y, 0.199, k % 5 ? 6 * u01(k, 3, 0) : 0);
                const std::string where = fmt::format("{} {}", name, k);
                const Manifold m = OnGround(ground, solid, pose, top).manifold();
                ASSERT_EQ(m.regions.size(), 1u) << where;
                const ManifoldRegion& r = m.regions[0];
                EXPECT_EQ(r.kind, RegionKind::crossing) << where;
                expect_near(r.normal, Vector3d::UnitZ(), 1e-15, where); // no inner edge of the plane tilts it
                EXPECT_LE(r.depth_lower, 0.001 + 1e-12) << where;
                EXPECT_GE(r.depth_upper, 0.001 - 1e-12) << where;
                EXPECT_LE(r.depth_upper - r.depth_lower, 1e-10) << where;
                EXPECT_LT(r.normal_error, 1e-12) << where;
                ASSERT_EQ(m.points.size(), 4u) << where;
                for (const ManifoldPoint& p : m.points) {
                    EXPECT_NEAR(p.depth, 0.001, 1e-12) << where;
                    EXPECT_NEAR(p.point_a.z(), 0, 1e-12) << where;
                    const Vector3d own = pose.inverse() * p.point_b;
                    expect_near(own.cwiseAbs(), half, 1e-9, where);
                }
            }
        }
}

Terrain hills()
{
    constexpr std::uint32_t side = 41;
    std::vector<double> heights;
    for (std::uint32_t k = 0; k < side * side; ++k)
        heights.push_back(0.6 * std::sin(0.37 * double(k % side)) + 0.5 * std::cos(0.29 * double(k / side)));
    TerrainGrid grid{.columns = side, .rows = side};
    grid.spacing = {0.25, 0.25};
    return make_terrain("hills", grid, heights);
}

TEST(SolidsOnTriangles, LeaveATerrainUpward)
{
    const std::vector<Shape> solids = {Sphere{0.2},          Capsule{0.1, 0.6},          Cylinder{0.2, 0.5},
                                       Cone{0.25, 0.8},      Ellipsoid{{0.3, 0.2, 0.1}}, Box{{0.2, 0.3, 0.1}},
                                       Box{{0.4, 0.4, 0.05}}};
    const GeometryData ground = hills();
    std::size_t met = 0, below = 0;
    for (std::uint64_t k = 0; k < 700; ++k) {
        const Shape& solid = solids[k % solids.size()];
        Isometry3d pose = at(1 + 8 * u01(k, 1, 0), 1 + 8 * u01(k, 2, 0), 0);
        const double x = pose.translation().x(), y = pose.translation().y();
        pose.translation().z() = 0.6 * std::sin(1.48 * x) + 0.5 * std::cos(1.16 * y) - 0.5 * u01(k, 3, 0);
        pose.rotate(
            Eigen::AngleAxisd(6 * u01(k, 4, 0), Vector3d(u01(k, 5, 0) - 0.5, u01(k, 6, 0) - 0.5, 0.3).normalized()));
        const OnGround scene(ground, solid, pose);
        const bool meets = scene.verdict() != Verdict::separate;
        const Manifold m = scene.manifold(0.005);
        EXPECT_TRUE(!meets || !m.regions.empty()) << k;
        met += meets, below += !meets && !m.regions.empty();
        for (const ManifoldRegion& r : m.regions) {
            if (r.kind == RegionKind::near) continue;
            // Along a slope at most, never through the ground.
            const Vector3d& p = m.points[r.first].point_a;
            const Vector3d up(-0.6 * 1.48 * std::cos(1.48 * p.x()), 0.5 * 1.16 * std::sin(1.16 * p.y()), 1);
            EXPECT_GT(r.normal.dot(up.normalized()), -0.1) << k << ' ' << solid.index() << ' ' << int(r.kind);
        }
    }
    EXPECT_GT(met, 300u);
    EXPECT_GT(below, 20u);
}

TEST(SolidsOnTriangles, KeepFeaturesWhileTheySlide)
{
    for (const int cells : {3, 9}) {
        std::vector<std::pair<FeatureBits, FeatureBits>> first;
        for (int step = 0; step < 60; ++step) {
            const Manifold m =
                OnGround(flat_ground(5, cells), Box{{0.4, 0.3, 0.2}}, turned(0.013 * step, 0.007 * step, 0.1995, 0.3))
                    .manifold();
            ASSERT_EQ(m.points.size(), 4u) << step;
            std::vector<std::pair<FeatureBits, FeatureBits>> features;
            for (const ManifoldPoint& p : m.points) features.emplace_back(p.feature_a, p.feature_b);
            std::ranges::sort(features);
            if (step == 0) first = features;
            EXPECT_EQ(features, first) << step;
        }
    }
}

TEST(SolidsOnTriangles, LieOnARidgeAndInAValley)
{
    for (const Shape& solid : {Shape(Box{{0.4, 0.4, 0.2}}), hull_of_box({0.4, 0.4, 0.2})}) {
        const Manifold ridge = OnGround(two_slopes(1), solid, at(0.05, 0.1, 0.199)).manifold();
        ASSERT_EQ(ridge.regions.size(), 1u);
        expect_near(ridge.regions[0].normal, Vector3d::UnitZ(), 1e-9, "ridge");
        EXPECT_NEAR(ridge.regions[0].depth_upper, 0.001, 1e-9);
        EXPECT_NEAR(ridge.regions[0].depth_lower, 0.001, 1e-9);
        EXPECT_EQ(ridge.points.size(), 2u);
        for (const ManifoldPoint& p : ridge.points) {
            EXPECT_NEAR(p.point_a.x(), 0, 1e-9);
            EXPECT_NEAR(p.point_a.z(), 0, 1e-9);
        }
        // The lower edges of the box are 1 mm below the slopes.
        const double height = 0.4 * 0.2 + 0.2 - 0.001;
        const Manifold valley = OnGround(two_slopes(-1), solid, at(0, 0.1, height)).manifold();
        ASSERT_EQ(valley.regions.size(), 2u);
        const Vector3d slope = Vector3d(1, 0, 5).normalized();
        for (const ManifoldRegion& r : valley.regions) {
            EXPECT_NEAR(std::abs(r.normal.x()), slope.x(), 1e-12);
            EXPECT_NEAR(r.normal.z(), slope.z(), 1e-12);
            EXPECT_EQ(r.count, 2u);
            EXPECT_NEAR(r.depth_upper, 0.001 * slope.z(), 1e-9);
            EXPECT_NEAR(r.depth_lower, 0.001 * slope.z(), 1e-9);
        }
    }
}

TEST(SolidsOnTriangles, HangOverABorder)
{
    for (const double tilt : {0.0, 0.02, -0.02})
        for (const GeometryData& ground : {GeometryData(flat_ground(1, 3)), GeometryData(make_box_mesh({1, 1, 1}))}) {
            const bool closed = std::get<Mesh>(ground).triangles.size() == 12;
            Isometry3d pose = at(1, 0.1, 0.199);
            pose.linear() = Eigen::AngleAxisd(tilt, Vector3d::UnitY()).toRotationMatrix();
            const Manifold m = OnGround(ground, Box{{0.4, 0.3, 0.2}}, pose, closed ? 1 : 0).manifold();
            ASSERT_FALSE(m.regions.empty()) << tilt;
            for (const ManifoldRegion& r : m.regions) { // never aside, out of the wall below the border
                EXPECT_GT(r.normal.z(), 0.99) << tilt;
                EXPECT_EQ(r.open, !closed);
                EXPECT_LT(r.depth_upper, 0.02);
            }
            for (const ManifoldPoint& p : m.points) EXPECT_LE(p.point_a.x(), 1 + 1e-9);
        }
}

TEST(SolidsOnTriangles, AreNearWithinTheMargin)
{
    for (const auto& [name, make] : grounds) {
        const GeometryData ground = make();
        if (std::holds_alternative<Shape>(ground)) continue;
        for (const Shape& solid : {Shape(Box{{0.4, 0.3, 0.2}}), hull_of_box({0.4, 0.3, 0.2})}) {
            const OnGround pair(ground, solid, turned(0.1, 0.2, 0.2005, 0.4), top_of(name));
            EXPECT_TRUE(pair.manifold().regions.empty()) << name;
            EXPECT_TRUE(pair.manifold(4e-4).regions.empty()) << name;
            const Manifold m = pair.manifold(1e-3);
            ASSERT_EQ(m.regions.size(), 1u) << name;
            EXPECT_EQ(m.regions[0].kind, RegionKind::near) << name;
            expect_near(m.regions[0].normal, Vector3d::UnitZ(), 1e-15, name);
            EXPECT_NEAR(m.regions[0].depth_upper, -5e-4, 1e-9) << name;
            ASSERT_EQ(m.points.size(), 4u) << name;
            for (const ManifoldPoint& p : m.points) EXPECT_NEAR(p.depth, -5e-4, 1e-9) << name;
        }
    }
}

/// Deep shapes are not lost: their surfaces are compared as surfaces of meshes are.
TEST(SolidsOnTriangles, AreNeverLostWhereTheyAreDeep)
{
    const Shape box = Box{{0.4, 0.3, 0.2}};
    const Mesh plate = make_box_mesh({2, 2, 0.01}),
               spike = make_mesh("spike", {{-0.05, -0.05, -1}, {0.05, -0.05, -1}, {0, 0.05, -1}, {0, 0, 0.15}},
                                 {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
    const struct {
        const char* name;
        GeometryData ground;
        Isometry3d pose;
        RegionKind kind;
    } cases[] = {{"sunk", make_box_mesh({2, 2, 1}), at(0.1, 0.1, 0.95), RegionKind::crossing},
                 {"below a terrain", flat_terrain(), at(0.1, 0.2, -1), RegionKind::enclosed},
                 {"through a plate", plate, at(0.1, 0.2, 0.15), RegionKind::crossing},
                 {"in a mesh", make_box_mesh({2, 2, 1}), at(0.1, 0.2, 0.3), RegionKind::enclosed},
                 {"around a mesh", make_sphere_mesh(0.1, 80), at(0.01, 0.02, 0), RegionKind::enclosed},
                 {"on a spike", spike, at(0.01, 0.02, 0.3), RegionKind::crossing},
                 {"in a fine mesh", make_sphere_mesh(0.5, 5000), at(0.45, 0, 0), RegionKind::crossing}};
    for (const auto& c : cases) {
        const OnGround pair(c.ground, box, c.pose);
        const Manifold m = pair.manifold(), near = pair.manifold(0.01);
        ASSERT_FALSE(m.regions.empty()) << c.name;
        EXPECT_EQ(m.regions[0].kind, c.kind) << c.name;
        EXPECT_FALSE(near.regions.empty()) << c.name;
        EXPECT_EQ(near.regions[0].kind, c.kind) << c.name;
    }
    // The tip of the spike pushes the box up.
    const Manifold m = OnGround(spike, box, at(0.01, 0.02, 0.3)).manifold();
    ASSERT_EQ(m.regions.size(), 1u);
    expect_near(m.regions[0].normal, Vector3d::UnitZ(), 1e-9, "spike");
    EXPECT_NEAR(m.regions[0].depth_upper, 0.05, 1e-9);
}

/// The distance is found by a search over boxes, and the moved bodies have it, too.
TEST(SolidsOnTriangles, AgreeWithDistancesAtRandomPoses)
{
    int met = 0, near = 0;
    for (std::uint64_t seed = 0; seed < 600; ++seed) {
        const std::string where = fmt::format("seed {}", seed);
        const Shape solid = seed % 2 ? Shape(Box{{0.2 + 0.2 * u01(seed, 1, 0), 0.2, 0.1}})
                                     : Shape(ConvexHull{make_sphere_mesh(0.25, seed % 4 ? 80 : 20).vertices});
        TerrainGrid grid{.columns = 21, .rows = 21};
        grid.spacing = {0.5, 0.5}, grid.origin = {-5, -5, 0};
        std::vector<double> heights;
        for (std::uint64_t k = 0; k < 441; ++k) heights.push_back(0.1 * u01(seed, 2, k));
        const Terrain terrain = make_terrain("bumps", grid, heights);
        const GeometryData ground = seed % 3   ? GeometryData(terrain)
                                    : seed % 6 ? GeometryData(mesh_of(terrain))
                                               : make_sphere_mesh(3, 2000);
        Isometry3d pose = random_pose(seed, 1);
        pose.translation().z() = (seed % 6 ? 0 : 3) + 0.1 + 0.3 * u01(seed, 3, 0);
        if (seed % 6 == 0) pose.translation().head<2>() *= 0.1;
        const double margin = 0.05;
        OnGround pair(ground, solid, pose);
        const Manifold m = pair.manifold(margin), exact = pair.manifold();
        const double distance = pair.distance();
        const bool meet = pair.verdict() == Verdict::colliding;
        EXPECT_EQ(!m.regions.empty(), meet || distance <= margin) << where;
        EXPECT_EQ(!exact.regions.empty(), meet) << where;
        met += meet, near += !meet && distance <= margin;
        double deepest = -1;
        for (const ManifoldRegion& r : m.regions) {
            EXPECT_LE(r.depth_lower, r.depth_upper) << where;
            EXPECT_EQ(r.kind == RegionKind::near && !meet, !meet) << where;
            deepest = std::max(deepest, r.depth_upper);
            if (!(r.depth_lower > 1e-9)) continue;
            const Isometry3d moved = Eigen::Translation3d((r.depth_lower - 1e-9) * r.normal) * pose;
            EXPECT_NE(OnGround(ground, solid, moved).verdict(), Verdict::separate) << where; // and so do the others
        }
        if (!meet && distance <= margin) {
            EXPECT_GE(deepest, -distance - 1e-9) << where;
            EXPECT_LE(m.regions[0].depth_lower, -distance + 1e-9) << where;
        }
        for (const ManifoldPoint& p : m.points) {
            const Two on_a(ground, at(0, 0, 0), Shape(Sphere{1e-9}), Isometry3d(Eigen::Translation3d(p.point_a))),
                on_b(solid, pose, Shape(Sphere{1e-9}), Isometry3d(Eigen::Translation3d(p.point_b)));
            EXPECT_LE(on_a.world.pairs().distance(on_a.a, on_a.b).upper, p.depth_error + 1e-7) << where;
            EXPECT_LE(on_b.world.pairs().distance(on_b.a, on_b.b).upper, p.depth_error + 1e-7) << where;
        }
    }
    EXPECT_GT(met, 150);
    EXPECT_GT(near, 20);
}

TEST(SolidsOnTriangles, ABallBehindAWallIsEnclosedOnlyIfItIsInside)
{
    const Two inside(make_box_mesh({2, 2, 2}), at(0, 0, 0), Shape(Sphere{0.25}), at(1.7, 0.1, 0.2));
    const Manifold m = inside.world.pairs().manifold(inside.a, inside.b, {.margin = 0.1});
    ASSERT_EQ(m.regions.size(), 1u);
    EXPECT_EQ(m.regions[0].kind, RegionKind::enclosed);
    expect_near(m.regions[0].normal, Vector3d::UnitX(), 1e-9, "wall");
    EXPECT_NEAR(m.regions[0].depth_upper, 0.55, 1e-9);
    EXPECT_NEAR(m.regions[0].depth_lower, 0.05, 1e-9);
    // The far side of a thin plate does not pull a ball that is above it.
    const Two above(make_box_mesh({2, 2, 0.01}), at(0, 0, 0), Shape(Sphere{0.25}), at(0.3, 0.1, 0.28));
    const Manifold far = above.world.pairs().manifold(above.a, above.b, {.margin = 0.1});
    ASSERT_EQ(far.regions.size(), 1u);
    EXPECT_EQ(far.regions[0].kind, RegionKind::near);
    expect_near(far.regions[0].normal, Vector3d::UnitZ(), 1e-9, "plate");
}

} // namespace
} // namespace oncollide::manifold_scenes
