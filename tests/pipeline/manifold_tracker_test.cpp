// Points of manifolds over frames, near features, and bodies that come to rest on manifolds.
#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/pipeline/manifold_tracker.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "random_pose.hpp"

namespace oncollide::manifold_tracker_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Isometry3d at(const Vector3d& p)
{
    return Isometry3d(Eigen::Translation3d(p));
}

Mesh flat_ground(double half, int cells)
{
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (int y = 0; y <= cells; ++y)
        for (int x = 0; x <= cells; ++x)
            vertices.emplace_back(half * (2.0 * x / cells - 1), half * (2.0 * y / cells - 1), 0);
    for (int y = 0; y < cells; ++y)
        for (int x = 0; x < cells; ++x) {
            const auto v = static_cast<std::uint32_t>(y * (cells + 1) + x),
                       up = v + static_cast<std::uint32_t>(cells) + 1;
            triangles.push_back({v, v + 1, up}), triangles.push_back({v + 1, up + 1, up});
        }
    return make_mesh("ground", std::move(vertices), std::move(triangles));
}

TEST(ManifoldTracker, FollowsABoxThatSlidesOverManyTriangles)
{
    World world({.threads = 1});
    const BodyId ground = world.bodies().add({.model = world.models().add(flat_ground(2, 100)), .is_static = true});
    const BodyId box = world.bodies().add({.model = world.models().add(make_box_mesh({0.25, 0.2, 0.1}))});
    const PairOfBodies pair{box, ground};
    ManifoldTracker tracker;
    ManifoldLists lists;
    std::size_t kept = 0, all = 0;
    std::set<std::uint64_t> ids;
    for (int frame = 0; frame < 200; ++frame) {
        world.bodies().set_pose(box, at({-0.5 + 0.005 * frame, 0.0123 + 0.001 * frame, 0.0999}));
        world.pairs().manifold(std::span(&pair, 1), {}, lists);
        const auto& update = tracker.update(world, {&pair, 1}, lists);
        ASSERT_EQ(update.previous.size(), lists.points.size());
        for (const std::uint64_t id : update.ids) ids.insert(id);
        if (frame == 0) continue;
        all += lists.points.size();
        kept += lists.points.size() - std::size_t(std::ranges::count(update.previous, ManifoldTracker::none));
    }
    EXPECT_GE(kept, 0.99 * all);
    EXPECT_EQ(ids.size(), 4u);
    // It leaves, and comes back with new ids.
    world.bodies().set_pose(box, at({0, 0, 5}));
    world.pairs().manifold(std::span(&pair, 1), {}, lists);
    EXPECT_EQ(tracker.update(world, {&pair, 1}, lists).ended.size(), 4u);
    world.bodies().set_pose(box, at({0, 0, 0.0999}));
    world.pairs().manifold(std::span(&pair, 1), {}, lists);
    for (const std::uint64_t id : tracker.update(world, {&pair, 1}, lists).ids) EXPECT_FALSE(ids.contains(id));
}

TEST(ManifoldTracker, MatchesOneToOneAndRefusesOtherLengths)
{
    World world({.threads = 1});
    const ModelId box = world.models().add(make_box_mesh({0.5, 0.5, 0.5}));
    std::vector<PairOfBodies> pairs;
    std::vector<BodyId> bodies;
    for (int i = 0; i < 4; ++i) bodies.push_back(world.bodies().add({.model = box, .pose = at({0, 0, 0.999 * i})}));
    for (std::size_t i = 0; i + 1 < bodies.size(); ++i) pairs.push_back({bodies[i + 1], bodies[i]});
    ManifoldTracker tracker;
    ManifoldLists lists;
    for (int frame = 0; frame < 3; ++frame) {
        world.pairs().manifold(pairs, {}, lists);
        const auto& update = tracker.update(world, pairs, lists);
        const std::set<std::uint32_t> previous(update.previous.begin(), update.previous.end());
        EXPECT_EQ(previous.size(), frame ? lists.points.size() : 1);
        EXPECT_EQ(std::set<std::uint64_t>(update.ids.begin(), update.ids.end()).size(), lists.points.size());
        std::ranges::reverse(pairs); // their order does not matter
        if (frame) {
            EXPECT_TRUE(update.ended.empty());
        }
    }
    pairs.pop_back();
    EXPECT_THROW(tracker.update(world, pairs, lists), Error);
    EXPECT_THROW(ManifoldTracker(-1), Error);
}

/// The distance of two segments or of a point and a triangle, by a search that shares nothing with the library.
double least_distance(const std::vector<Vector3d>& x, const std::vector<Vector3d>& y)
{
    // Frank and Wolfe's method with exact line search converges slowly but surely: alternating projections here.
    const auto nearest = [](const std::vector<Vector3d>& s, const Vector3d& p) -> Vector3d {
        const auto on = [&](const Vector3d& u, const Vector3d& v) -> Vector3d {
            const double length2 = (v - u).squaredNorm();
            return length2 > 0 ? Vector3d(u + std::clamp((v - u).dot(p - u) / length2, 0.0, 1.0) * (v - u)) : u;
        };
        if (s.size() == 1) return s[0];
        if (s.size() == 2) return on(s[0], s[1]);
        const Vector3d n = (s[1] - s[0]).cross(s[2] - s[0]);
        bool inside = true;
        for (int k = 0; k < 3; ++k) inside &= n.dot((s[(k + 1) % 3] - s[k]).cross(p - s[k])) >= 0;
        if (inside) return p - n.dot(p - s[0]) / n.squaredNorm() * n;
        Vector3d best = on(s[0], s[1]);
        for (const Vector3d& q : {on(s[1], s[2]), on(s[2], s[0])})
            if ((q - p).norm() < (best - p).norm()) best = q;
        return best;
    };
    Vector3d p = x[0];
    double last = 1e9;
    for (int i = 0; i < 20000; ++i) {
        const Vector3d q = nearest(y, p);
        p = nearest(x, q);
        const double now = (p - q).norm();
        if (last - now < 1e-14) break;
        last = now;
    }
    return last;
}

TEST(NearFeatures, FindAllThatBruteForceFinds)
{
    std::size_t total = 0;
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        const Mesh mesh_a =
            seed % 3 ? make_torus_knot_mesh(2, 3, 0.4, 0.2, 0.08, 120) : make_box_mesh({0.3, 0.2, 0.25});
        const Mesh mesh_b = make_sphere_mesh(0.3, 60);
        const Isometry3d pose_a = random_pose(seed, 0.2), pose_b = random_pose(seed + 40, 0.3);
        World world({.threads = 1});
        const PairOfBodies pair{world.bodies().add({.model = world.models().add(mesh_a), .pose = pose_a}),
                                world.bodies().add({.model = world.models().add(mesh_b), .pose = pose_b})};
        const double dhat = 0.05;
        Lists<NearFeatures> lists;
        world.pairs().near_features(std::span(&pair, 1), dhat, lists);
        const std::set<std::pair<FeatureBits, FeatureBits>> found = [&] {
            std::set<std::pair<FeatureBits, FeatureBits>> all;
            for (const NearFeatures& f : lists.items) all.emplace(f.a, f.b);
            return all;
        }();
        EXPECT_EQ(found.size(), lists.items.size());
        for (const NearFeatures& f : lists.items) {
            EXPECT_LE(f.lower, dhat);
            EXPECT_LE(f.upper - f.lower, 1e-9);
            EXPECT_NEAR((f.point_a - f.point_b).norm(), f.upper, 1e-9);
        }
        // Pairs of a vertex and a face whose nearest point is inside the face: no rounding moves it to an edge.
        const auto bits = [](std::uint64_t kind, std::uint64_t number) { return kind << 62 | number; };
        for (std::uint32_t v = 0; v < mesh_a.vertices.size(); ++v)
            for (std::uint32_t t = 0; t < mesh_b.triangles.size(); ++t) {
                const Vector3d p = pose_a * mesh_a.vertices[v];
                std::vector<Vector3d> face;
                for (const std::uint32_t k : mesh_b.triangles[t]) face.push_back(pose_b * mesh_b.vertices[k]);
                const double distance = least_distance({p}, face);
                if (distance > dhat - 1e-9) continue;
                const Vector3d n = (face[1] - face[0]).cross(face[2] - face[0]).normalized();
                bool inside = true;
                for (int k = 0; k < 3; ++k) inside &= n.dot((face[(k + 1) % 3] - face[k]).cross(p - face[k])) > 1e-6;
                if (!inside) continue;
                ++total;
                EXPECT_TRUE(found.contains({bits(1, v), bits(3, t)})) << seed << ": vertex " << v << ", face " << t;
            }
        // Every two triangles this near have features in the list that are as near.
        for (const Triangle& s : mesh_a.triangles)
            for (const Triangle& t : mesh_b.triangles)
                for (int i = 0; i < 3; ++i)
                    for (int k = 0; k < 3; ++k) {
                        const std::vector<Vector3d> u{pose_a * mesh_a.vertices[s[i]],
                                                      pose_a * mesh_a.vertices[s[(i + 1) % 3]]},
                            v{pose_b * mesh_b.vertices[t[k]], pose_b * mesh_b.vertices[t[(k + 1) % 3]]};
                        const double distance = least_distance(u, v);
                        if (distance > dhat - 1e-6 || distance < 1e-6) continue;
                        const bool listed = std::ranges::any_of(lists.items, [&](const NearFeatures& f) {
                            return f.lower <= distance + 1e-6 && least_distance({f.point_a}, u) < 1e-6 &&
                                   least_distance({f.point_b}, v) < 1e-6;
                        });
                        EXPECT_TRUE(listed) << seed;
                        ++total;
                    }
    }
    EXPECT_GT(total, 1000u);
    World world;
    const ModelId ball = world.models().add(Shape(Sphere{1}));
    const PairOfBodies pair{world.bodies().add({.model = ball}), world.bodies().add({.model = ball})};
    Lists<NearFeatures> lists;
    EXPECT_THROW(world.pairs().near_features(std::span(&pair, 1), 0.1, lists), Error);
    EXPECT_THROW(world.pairs().near_features(std::span(&pair, 1), -0.1, lists), Error);
}

} // namespace
} // namespace oncollide::manifold_tracker_test
