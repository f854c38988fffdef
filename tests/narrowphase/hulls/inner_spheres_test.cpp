// Spheres inside meshes, compared with all triangles, and the collisions that they prove, compared with traversals.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/broadphase/bounds/pose_bounds.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/hulls/inner_spheres.hpp>
#include <oncollide/narrowphase/inside/point_location.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>
#include <oncollide/samples/generators.hpp>

#include "random_pose.hpp"

namespace oncollide {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Mesh scaled(const Mesh& mesh, double scale, const Vector3d& by = Vector3d::Zero())
{
    return transformed("scaled", mesh, scale, by);
}
Mesh without(Mesh mesh, std::size_t first, std::size_t count)
{
    const auto at = mesh.triangles.begin() + static_cast<std::ptrdiff_t>(first);
    mesh.triangles.erase(at, at + static_cast<std::ptrdiff_t>(count));
    return make_mesh("holes", mesh.vertices, mesh.triangles);
}
/// Each triangle twice: every edge is even, and no ray can find an inside.
Mesh doubled(const Mesh& mesh)
{
    std::vector<Triangle> triangles = mesh.triangles;
    triangles.insert(triangles.end(), mesh.triangles.begin(), mesh.triangles.end());
    return make_mesh("doubled", mesh.vertices, triangles);
}
/// A cup: a sphere minus a smaller sphere that protrudes from it, as a surface of revolution.
Mesh cup()
{
    constexpr std::uint32_t around = 24, along = 12;
    std::vector<Vector3d> vertices{{0, 0, -1}};
    std::vector<Triangle> triangles;
    const auto ring = [&](double radius, double z) {
        for (std::uint32_t i = 0; i < around; ++i) {
            const double angle = 2 * M_PI * i / around;
            vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
        }
    };
    for (std::uint32_t k = 1; k <= along; ++k) ring(std::sin(0.2 * k), -std::cos(0.2 * k));
    for (std::uint32_t k = along; k >= 1; --k) ring(0.8 * std::sin(0.2 * k), -0.8 * std::cos(0.2 * k));
    vertices.emplace_back(0, 0, -0.8);
    for (std::uint32_t i = 0; i < around; ++i) {
        const std::uint32_t j = (i + 1) % around, last = static_cast<std::uint32_t>(vertices.size()) - 1;
        triangles.push_back({0, 1 + j, 1 + i}), triangles.push_back({last, last - around + i, last - around + j});
        for (std::uint32_t k = 0; k + 1 < 2 * along; ++k) {
            const std::uint32_t at = 1 + k * around, up = at + around;
            triangles.push_back({at + i, at + j, up + j}), triangles.push_back({at + i, up + j, up + i});
        }
    }
    return make_mesh("cup", vertices, triangles);
}

std::vector<Mesh> meshes()
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 600), ball = make_sphere_mesh(1, 400);
    return {knot,
            ball,
            cup(),
            without(ball, 10, 40),
            scaled(ball, 0.4),
            make_box_mesh({0.5, 0.1, 1.5}),
            doubled(ball),
            make_soup_mesh(60, 0.5, 1.5, 6),
            make_needles_mesh(30, 1, 1e4, 2, 5),
            make_mesh("a point", {{1, 2, 3}}, {{0, 0, 0}}),
            scaled(knot, 1, {1e4, -1e4, 1e3})};
}

Vector3d direction(std::uint64_t i)
{
    return Vector3d(u01(5, i, 0) - 0.5, u01(5, i, 1) - 0.5, u01(5, i, 2) - 0.5).normalized();
}

TEST(InnerSpheres, AreEnclosed)
{
    std::size_t enclosed = 0;
    PointLocator locator;
    for (const Mesh& mesh : meshes()) {
        const InnerSpheres balls(mesh);
        for (std::size_t i = 0; i < balls.count(); ++i) {
            const Vector3d centre = balls.centre() + balls.ball(i);
            double nearest = HUGE_VAL;
            for (const Triangle& t : mesh.triangles)
                nearest =
                    std::min(nearest, triangle_distance({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]},
                                                        {centre, centre, centre}));
            const double rounding = 0x1p-20 * balls.radius();
            EXPECT_LE(balls.radius(i), nearest + rounding);
            EXPECT_LE((centre - balls.centre()).norm(), balls.radius() + rounding);
            if (i >= balls.enclosed()) {
                EXPECT_EQ(balls.radius(i), 0);
                EXPECT_LE(nearest, rounding);
                continue;
            }
            ++enclosed;
            ASSERT_TRUE(is_closed(mesh));
            const RelativePose stay(Isometry3d::Identity(), Isometry3d::Identity());
            EXPECT_EQ(locator.place(centre, mesh, nullptr, stay), PointLocation::inside);
        }
    }
    EXPECT_GT(enclosed, 60u);
}

/// Spheres as large as a body allows, in all of its parts.
TEST(InnerSpheres, FillABody)
{
    const InnerSpheres ball(make_sphere_mesh(1, 2000)), rod(make_box_mesh({1, 0.3, 0.3}));
    EXPECT_GT(ball.radius(0), 0.9);
    ASSERT_GT(rod.enclosed(), 4u);
    double least = 0, most = 0;
    for (std::size_t i = 0; i < rod.enclosed(); ++i) {
        least = std::min(least, rod.ball(i)[0]), most = std::max(most, rod.ball(i)[0]);
        EXPECT_LE(rod.radius(i), 0.3);
    }
    EXPECT_LT(least, -0.5);
    EXPECT_GT(most, 0.5);
}

TEST(InnerSpheres, MeetOnlyWhereSurfacesDoHoweverTheBodiesMoveWithinTheDepth)
{
    Traversal walk;
    int met = 0, moved = 0, apart = 0;
    const std::vector<Mesh> all = meshes();
    std::vector<InnerSpheres> balls;
    std::vector<GeometryData> data(all.begin(), all.end());
    for (const Mesh& mesh : all) balls.emplace_back(mesh);
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t k = 0; k <= i; ++k) {
            const Mesh &a = all[i], &b = all[k];
            ObbTree tree_a(a), tree_b(b);
            const PoseBounds bounds_a(data[i]), bounds_b(data[k]);
            const double size = 0.5 * (a.bounds.diagonal() + b.bounds.diagonal());
            for (std::uint64_t j = 0; j < 60; ++j) {
                Isometry3d at_a = random_pose(100 * i + j, 1), at_b = random_pose(7000 * k + j, 1);
                if (j % 3 == 0) at_b.linear() *= 1 + 0x1p-21, at_a.linear() *= 1 - 0x1p-21; // at the limit of rigidity
                const double off = 0.5 * size * u01(9, j, 0) * (j % 4 == 0 ? 0.2 : 1);
                at_b.translation() =
                    at_a * a.bounds.centre() - at_b.linear() * b.bounds.centre() + off * direction(100 * i + j);
                const double depth = meeting_depth(balls[i], balls[k], RelativePose(at_a, at_b));
                const bool meet = walk.first_meeting(tree_a, tree_b, RelativePose(at_a, at_b)).pair.has_value();
                EXPECT_TRUE(meet || depth == 0) << i << ' ' << k << ' ' << j;
                apart += !meet, met += depth > 0;
                for (std::uint64_t step = 0; depth > 0 && step < 4; ++step) {
                    const auto nudge = [&](const Isometry3d& from, const Vector3d& centre, std::uint64_t seed) {
                        Isometry3d to = from;
                        to.linear() = Eigen::AngleAxisd(0.2 * u01(1, seed, step), direction(seed)) * from.linear();
                        to.translation() = from * centre - to.linear() * centre + depth * direction(seed + 7 * step);
                        return to;
                    };
                    const Isometry3d next_a = nudge(at_a, a.bounds.centre(), 11 * j + k),
                                     next_b = nudge(at_b, b.bounds.centre(), 13 * j + i);
                    const double travel = bounds_a.motion(at_a, next_a) + bounds_b.motion(at_b, next_b);
                    // The whole way could separate some: moves by a share that the depth allows.
                    const double share = 0.97 * std::min(1.0, depth / travel);
                    const auto part_way = [&](const Isometry3d& from, const Isometry3d& to) {
                        Isometry3d pose;
                        pose.linear() = Eigen::Quaterniond(from.linear())
                                            .normalized()
                                            .slerp(0.5 * share, Eigen::Quaterniond(to.linear()).normalized())
                                            .toRotationMatrix();
                        pose.translation() = from.translation() + 0.5 * share * (to.translation() - from.translation());
                        return pose;
                    };
                    const Isometry3d then_a = part_way(at_a, next_a), then_b = part_way(at_b, next_b);
                    if (bounds_a.motion(at_a, then_a) + bounds_b.motion(at_b, then_b) >= depth) continue;
                    ++moved;
                    EXPECT_TRUE(walk.first_meeting(tree_a, tree_b, RelativePose(then_a, then_b)).pair)
                        << i << ' ' << k << ' ' << j << ' ' << step;
                }
            }
        }
    EXPECT_GT(met, 100);
    EXPECT_GT(moved, 300);
    EXPECT_GT(apart, 500);
}

} // namespace
} // namespace oncollide
