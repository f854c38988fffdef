// Properties of all manifolds, and convex solids against a truth of their own.
#include <algorithm>

#include "pipeline/manifold_scenes.hpp"
#include "verify/oracle/manifold_truth.hpp"
#include "verify/trials/manifold_trial.hpp"

namespace oncollide::manifold_scenes {
namespace {

ManifoldLists swapped(ManifoldLists lists)
{
    for (ManifoldRegion& r : lists.regions) r.normal = -r.normal;
    for (ManifoldPoint& p : lists.points)
        std::swap(p.point_a, p.point_b), std::swap(p.feature_a, p.feature_b), p.normal = -p.normal;
    return lists;
}

/// Every two kinds at random poses: properties, the same in both orders, threads and a moved frame.
TEST(Manifolds, EveryTwoKindsKeepTheirPromises)
{
    std::size_t regions = 0;
    for (std::uint64_t seed = 0; seed < 2; ++seed)
        for (std::size_t i = 0; i < kinds; ++i)
            for (std::size_t k = 0; k < kinds; ++k) {
                const std::string where = fmt::format("{} and {}, seed {}", every_kind[i], every_kind[k], seed);
                const Two two(draw_geometry(i, seed), random_pose(3 * seed + i, 0.4), draw_geometry(k, seed + 1),
                              random_pose(5 * seed + k, 0.4));
                const PairOfBodies there{two.a, two.b}, back{two.b, two.a};
                ManifoldLists first, second;
                const ManifoldOptions options{.margin = seed % 2 ? 0.05 : 0};
                two.world.pairs().manifold(std::span(&there, 1), options, first),
                    two.world.pairs().manifold(std::span(&back, 1), options, second);
                EXPECT_EQ(hash_of(first), hash_of(swapped(second))) << where;
                const Manifold m = two.manifold(options);
                check(m, where);
                regions += m.regions.size();
                const Verdict verdict = two.world.pairs().decide(two.a, two.b).verdict;
                const bool planes = i + 1 == kinds && k + 1 == kinds;
                if (verdict == Verdict::colliding && !planes) {
                    EXPECT_FALSE(m.regions.empty()) << where;
                }
            }
    EXPECT_GT(regions, 100u);
}

/// The surface of the overlap of two convex solids: each face of one, clipped with the planes of the other.
struct CommonSolid {
    Vector3d area_a = Vector3d::Zero(); ///< of the faces of a
    double volume = 0;
    std::vector<Vector3d> points_a, points_b;
    bool aligned = false; ///< faces of both lie in one plane
};
CommonSolid common_solid(const Mesh& a, const Isometry3d& pose_a, const Mesh& b, const Isometry3d& pose_b)
{
    using Real = Eigen::Matrix<long double, 3, 1>;
    const auto faces = [](const Mesh& mesh, const Isometry3d& pose) {
        std::vector<std::array<Real, 3>> all;
        for (const Triangle& t : mesh.triangles) {
            std::array<Real, 3> face;
            for (int k = 0; k < 3; ++k) face[k] = (pose * mesh.vertices[t[k]]).cast<long double>();
            all.push_back(face);
        }
        return all;
    };
    const auto normal = [](const std::array<Real, 3>& f) -> Real {
        return (f[1] - f[0]).cross(f[2] - f[0]).normalized();
    };
    const auto of_a = faces(a, pose_a), of_b = faces(b, pose_b);
    CommonSolid common;
    Real area = Real::Zero();
    long double volume = 0;
    for (const bool first : {true, false})
        for (const auto& face : first ? of_a : of_b) {
            std::vector<Real> polygon(face.begin(), face.end()), next;
            for (const auto& plane : first ? of_b : of_a) {
                const Real n = normal(plane);
                const auto height = [&](const Real& p) { return n.dot(p - plane[0]); };
                if (std::abs(n.dot(normal(face))) > 1 - 1e-15L && std::abs(height(face[0])) < 1e-12L) {
                    common.aligned = true;
                    if (first && n.dot(normal(face)) > 0) continue; // a's face bounds both
                    polygon.clear();
                }
                next.clear();
                for (std::size_t i = 0; i < polygon.size(); ++i) {
                    const Real &u = polygon[i], &v = polygon[(i + 1) % polygon.size()];
                    if (height(u) < 0) next.push_back(u);
                    if ((height(u) < 0) != (height(v) < 0))
                        next.push_back(u + height(u) / (height(u) - height(v)) * (v - u));
                }
                polygon.swap(next);
            }
            for (const Real& p : polygon) (first ? common.points_a : common.points_b).push_back(p.cast<double>());
            for (std::size_t i = 2; i < polygon.size(); ++i) {
                const Real s = 0.5L * (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]);
                if (first) area += s;
                volume += s.dot(polygon[0]) / 3;
            }
        }
    common.area_a = area.cast<double>(), common.volume = double(volume);
    return common;
}

/// Random boxes and hulls, half of them on a grid so that faces, edges and corners coincide.
TEST(Manifolds, AreasVolumesAndDepthsOfConvexSolids)
{
    std::size_t aligned = 0, known = 0;
    for (std::uint64_t seed = 0; seed < 4000; ++seed) {
        const bool grid = seed % 2;
        const auto pose = [&](std::uint64_t k) {
            if (!grid) return random_pose(7 * seed + k, 0.4);
            const auto step = [&](std::uint64_t i) { return 0.25 * std::floor(7 * u01(seed, k, i) - 3); };
            return at(step(0), step(1), step(2));
        };
        const auto mesh = [&](std::uint64_t k) {
            if (!grid && u01(seed, k, 20) < 0.5) return make_sphere_mesh(0.4, 80);
            const auto size = [&](std::uint64_t i) { return 0.25 * (1 + std::floor(3 * u01(seed, k, 10 + i))); };
            return make_box_mesh({size(0), size(1), size(2)});
        };
        const Mesh mesh_a = mesh(1), mesh_b = mesh(2);
        const Isometry3d pose_a = pose(1), pose_b = pose(2);
        const std::string where = fmt::format("seed {}", seed);
        const CommonSolid truth = common_solid(mesh_a, pose_a, mesh_b, pose_b);
        const Two two(mesh_a, pose_a, mesh_b, pose_b);
        const Manifold m = two.manifold();
        check(m, where);
        const bool enclosed =
            std::ranges::any_of(m.regions, [](const auto& r) { return r.kind == RegionKind::enclosed; });
        double volume = 0;
        for (const ManifoldRegion& r : m.regions) volume += r.volume;
        aligned += truth.aligned && truth.volume > 1e-9;
        if (!enclosed) {
            EXPECT_NEAR(volume, truth.volume, 1e-9) << where;
        }
        if (truth.volume > 1e-6) {
            EXPECT_FALSE(m.regions.empty()) << where;
        }
        for (const ManifoldRegion& r : m.regions) {
            double least = 1e9, most = -1e9;
            for (const Vector3d& p : truth.points_a) most = std::max(most, r.normal.dot(p));
            for (const Vector3d& p : truth.points_b) least = std::min(least, r.normal.dot(p));
            const bool one = m.regions.size() == 1 && r.kind == RegionKind::crossing;
            if (one && !truth.aligned) {
                EXPECT_LE(most - least, r.depth_upper + 1e-9) << where;
            }
            if (!one || r.normal_error > 1e-6 || truth.aligned || truth.area_a.norm() < 1e-3) continue;
            ++known;
            expect_near(r.normal, truth.area_a.normalized(), 1e-6, where);
            EXPECT_NEAR(r.area, truth.area_a.norm(), 1e-9) << where;
        }
        for (const ManifoldPoint& p : m.points) {
            if (enclosed || p.depth_error > 1e-6) continue;
            // A point of one solid is inside the other all the way.
            const auto above = [&](const Mesh& body, const Isometry3d& placed) {
                double most = -1e9;
                for (const Triangle& t : body.triangles) {
                    const Vector3d u = placed * body.vertices[t[0]], v = placed * body.vertices[t[1]],
                                   w = placed * body.vertices[t[2]], n = (v - u).cross(w - u).normalized();
                    most = std::max({most, n.dot(p.point_a - u), n.dot(p.point_b - u)});
                }
                return most;
            };
            EXPECT_LE(std::min(above(mesh_a, pose_a), above(mesh_b, pose_b)), 1e-9) << where;
        }
    }
    EXPECT_GT(aligned, 200u);
    EXPECT_GT(known, 400u);
}

TEST(Manifolds, NoContactIsFartherThanLost)
{
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        const Two two(make_torus_knot_mesh(2, 3, 0.4, 0.2, 0.08, 600), random_pose(seed, 0.3),
                      seed % 2 ? GeometryData(make_box_mesh({0.3, 0.3, 0.2}))
                               : GeometryData(make_torus_knot_mesh(2, 5, 0.4, 0.2, 0.06, 800)),
                      random_pose(seed + 100, 0.3));
        const Manifold m = two.manifold({.regions_per_pair = 1000});
        const std::string where = fmt::format("seed {}", seed);
        check(m, where);
        EXPECT_TRUE(m.complete);
        const std::vector<Contact> contacts = two.world.pairs().contacts(two.a, two.b);
        EXPECT_EQ(contacts.empty(), m.regions.empty()) << where;
        for (const Contact& c : contacts)
            for (const Vector3d& end : c.ends) {
                const bool kept = std::ranges::any_of(m.regions, [&](const ManifoldRegion& r) {
                    double nearest = std::numeric_limits<double>::infinity(), spread = 0;
                    for (std::uint32_t i = r.first; i < r.first + r.count; ++i) {
                        const Vector3d p = 0.5 * (m.points[i].point_a + m.points[i].point_b);
                        nearest = std::min(nearest, (p - end).norm());
                        for (std::uint32_t k = r.first; k < r.first + r.count; ++k)
                            spread = std::max(spread, (p - 0.5 * (m.points[k].point_a + m.points[k].point_b)).norm());
                    }
                    return nearest <= r.lost + spread + 1e-9;
                });
                EXPECT_TRUE(kept) << where;
            }
    }
}

TEST(Manifolds, MovingBothBodiesMovesTheManifold)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 0.4, 0.2, 0.08, 600);
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const Isometry3d a = random_pose(seed, 0.2), b = random_pose(seed + 50, 0.2), by = random_pose(seed + 99, 5);
        const Manifold m = Two(knot, a, make_box_mesh({0.3, 0.3, 0.3}), b).manifold();
        const Manifold moved = Two(knot, by * a, make_box_mesh({0.3, 0.3, 0.3}), by * b).manifold();
        ASSERT_EQ(m.regions.size(), moved.regions.size()) << seed;
        // Which body is taken first may change, and with it the order of regions of nearly equal depth.
        for (const ManifoldRegion& r : m.regions) {
            double nearest = 1;
            for (const ManifoldRegion& s : moved.regions)
                nearest =
                    std::min(nearest, (by.linear() * r.normal - s.normal).norm() + (by * r.centre - s.centre).norm() +
                                          std::abs(r.volume - s.volume) + std::abs(r.depth_upper - s.depth_upper));
            if (r.normal_error < 0.01) {
                EXPECT_LT(nearest, 1e-8) << seed;
            }
        }
    }
}

TEST(Manifolds, DoNotDependOnThreads)
{
    std::vector<std::uint64_t> hashes;
    for (const int threads : {1, 2, 8}) {
        World world({.threads = threads});
        const ModelId knot = world.models().add(make_torus_knot_mesh(2, 3, 0.4, 0.2, 0.08, 400));
        std::vector<PairOfBodies> pairs;
        std::vector<BodyId> bodies;
        for (std::uint64_t i = 0; i < 24; ++i)
            bodies.push_back(world.bodies().add({.model = knot, .pose = random_pose(i, 0.5)}));
        for (std::size_t i = 0; i + 1 < bodies.size(); ++i) pairs.push_back({bodies[i], bodies[i + 1]});
        ManifoldLists lists;
        world.pairs().manifold(pairs, {}, lists);
        EXPECT_EQ(lists.offsets.size(), pairs.size() + 1);
        EXPECT_EQ(lists.complete.size(), pairs.size());
        EXPECT_GT(lists.regions.size(), 0u);
        hashes.push_back(hash_of(lists));
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
}

TEST(Manifolds, CapsAreToldAndBadOptionsAreErrors)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 0.4, 0.2, 0.08, 600);
    Two two(knot, at(0, 0, 0), knot, random_pose(3, 0.1));
    ASSERT_GT(two.manifold().regions.size(), 1u);
    const Manifold one = two.manifold({.points_per_region = 2, .regions_per_pair = 1});
    EXPECT_FALSE(one.complete);
    EXPECT_EQ(one.regions.size(), 1u);
    EXPECT_LE(one.points.size(), 2u);
    const Manifold many = two.manifold({.points_per_region = 12, .points_per_pair = 1000});
    check(many, "many");
    EXPECT_LE(many.regions[0].lost, two.manifold().regions[0].lost + 1e-12);
    EXPECT_THROW((void)two.manifold({.margin = -1}), Error);
    EXPECT_THROW((void)two.manifold({.margin = std::nan("")}), Error);
    EXPECT_THROW((void)two.manifold({.normal_spread = 2}), Error);
    EXPECT_THROW((void)two.manifold({.points_per_region = 0}), Error);
    const BodyId gone = two.b;
    two.world.bodies().remove(two.b);
    EXPECT_THROW((void)two.world.pairs().manifold(two.a, gone), Error);
}

TEST(Manifolds, RationalArithmeticContradictsNoClaim)
{
    const tools::ManifoldTally tally = tools::try_manifolds(1, 3000, 2, [] {});
    EXPECT_EQ(tally.faults, 0u) << tally.first.seed << ": " << tally.first.what;
    EXPECT_GT(tally.met, 1500u);
    EXPECT_GT(tally.whole, 500u);
}

/// The way out of the other body leaves the overlap and crosses a face that is not in the region.
TEST(Manifolds, TheDepthCountsFacesOutsideTheOverlap)
{
    const tools::ManifoldTally tally = tools::try_manifolds(131085, 1, 1, [] {});
    EXPECT_EQ(tally.whole, 1u);
    EXPECT_EQ(tally.faults, 0u) << tally.first.what;
}

TEST(Manifolds, TheJudgeRejectsFalseClaims)
{
    // Two tetrahedra in general position; the tip of one is in the other.
    const auto tetrahedron = [](const Vector3d& by) {
        return make_mesh("tetrahedron",
                         {by + Vector3d(0.61, 0.02, 0), by + Vector3d(-0.43, 0.52, 0.01),
                          by + Vector3d(-0.41, -0.53, -0.02), by + Vector3d(0.03, 0.01, 0.7)},
                         {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
    };
    const Mesh below = tetrahedron({0, 0, 0}), above = tetrahedron({0.05, 0.07, 0.6});
    const auto surface = [](const Mesh& mesh) {
        oracle::Surface all;
        for (const auto& [a, b, c] : mesh.triangles)
            all.push_back({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
        return all;
    };
    const Two two(below, at(0, 0, 0), above, at(0, 0, 0));
    const Manifold right = two.manifold({.points_per_region = 1}); // loses some
    ASSERT_EQ(right.regions.size(), 1u);
    const auto fault = [&](auto change) {
        Manifold wrong = right;
        change(wrong.regions[0]);
        return oracle::judge_manifold(surface(below), surface(above), wrong).fault;
    };
    EXPECT_EQ(fault([](ManifoldRegion&) {}), "");
    EXPECT_NE(fault([](ManifoldRegion& r) { r.lost *= 1 - 1e-6; }), "");
    EXPECT_NE(fault([](ManifoldRegion& r) { r.depth_upper *= 1 - 1e-6; }), "");
    EXPECT_NE(fault([](ManifoldRegion& r) { r.depth_lower *= 1 + 1e-6; }), "");
    EXPECT_NE(fault([](ManifoldRegion& r) { r.normal = (r.normal + Vector3d(1e-5, 0, 0)).normalized(); }), "");
}

TEST(Manifolds, RegionsAndPairsShareTheLimitOfPointsInTurn)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 0.4, 0.2, 0.08, 600);
    const Two two(knot, at(0, 0, 0), knot, random_pose(3, 0.1));
    const Manifold all = two.manifold({.points_per_pair = 1000});
    ASSERT_GT(all.regions.size(), 3u);
    EXPECT_TRUE(all.complete);
    for (const std::uint32_t most : {1u, 3u, 7u, 20u}) {
        const std::string where = std::to_string(most);
        const Manifold m = two.manifold({.points_per_pair = most});
        check(m, where);
        EXPECT_FALSE(m.complete) << where;
        EXPECT_LE(m.points.size(), most) << where;
        EXPECT_GE(m.points.size(), std::min<std::size_t>(most, m.regions.size())) << where;
    }
    // Two pairs: a deep one with many points, and a box on another with four. Each gets its share.
    World world({.threads = 1});
    const ModelId model = world.models().add(knot), box = world.models().add(make_box_mesh({1, 1, 1}));
    const std::vector<BodyId> bodies = {world.bodies().add({.model = model}),
                                        world.bodies().add({.model = model, .pose = random_pose(3, 0.1)}),
                                        world.bodies().add({.model = box, .pose = at(9, 0, 0)}),
                                        world.bodies().add({.model = box, .pose = at(9, 0.1, 1.999)})};
    const std::vector<PairOfBodies> pairs = {{bodies[0], bodies[1]}, {bodies[2], bodies[3]}};
    ManifoldLists lists;
    for (const std::uint32_t most : {1u, 2u, 6u, 10u}) {
        world.pairs().manifold(pairs, {.points_in_all = most, .measures = true}, lists);
        ASSERT_EQ(lists.points.size(), most);
        EXPECT_FALSE(lists.complete[0]);
        std::size_t of_box = 0;
        for (std::size_t k = lists.offsets[1]; k < lists.offsets[2]; ++k) of_box += lists.regions[k].count;
        EXPECT_EQ(of_box, std::min(most / 2, 4u)) << most;
        EXPECT_EQ(lists.complete[1] != 0, of_box == 4) << most;
        for (std::size_t k = lists.offsets[1]; k < lists.offsets[2]; ++k)
            if (of_box == 3) {
                EXPECT_GT(lists.regions[k].lost, 1);
            }
    }
    EXPECT_THROW((void)two.manifold({.points_per_pair = 0}), Error);
}

TEST(Manifolds, SizesAndTrianglesWithoutArea)
{
    for (const double scale : {1e-6, 1e6, 1e12}) {
        const Two two(make_box_mesh(Vector3d(1, 1, 1) * scale), at(0, 0, 1.99 * scale),
                      make_box_mesh(Vector3d(2, 2, 1) * scale), at(0, 0, 0));
        const Manifold m = two.manifold();
        ASSERT_EQ(m.regions.size(), 1u) << scale;
        EXPECT_NEAR(m.regions[0].area / (scale * scale), 4, 1e-9);
        EXPECT_NEAR(m.regions[0].depth_upper / scale, 0.01, 1e-9);
    }
    Mesh box = make_box_mesh({1, 1, 1});
    box.triangles.push_back({0, 0, 1}), box.triangles.push_back({0, 1, 1}), box.triangles.push_back({2, 2, 2});
    const Mesh flat = make_mesh("flat", box.vertices, box.triangles);
    const Two two(flat, at(0.1, 0.1, 1.99), make_box_mesh({2, 2, 1}), at(0, 0, 0));
    const Manifold m = two.manifold();
    check(m, "flat");
    ASSERT_EQ(m.regions.size(), 1u);
    EXPECT_FALSE(m.regions[0].open);
    EXPECT_NEAR(m.regions[0].area, 4, 1e-9);
}

} // namespace
} // namespace oncollide::manifold_scenes
