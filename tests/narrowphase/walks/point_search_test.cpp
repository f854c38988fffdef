// The first guess of a distance.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/narrowphase/obb/oriented_box.hpp>
#include <oncollide/narrowphase/walks/point_search.hpp>
#include <oncollide/narrowphase/walks/walk_frame.hpp>

#include "narrowphase/mesh_cases.hpp"

namespace oncollide::mesh_cases {
namespace {

constexpr BoxPlacement at_home{{0, 0, 0}, false, {}, {}};

double squared_distance(const Vector3d& point, const TrianglePoints& triangle)
{
    return (nearest_on(triangle, point).at - point).squaredNorm();
}

/// Distance of a point of the tree's coordinates from the triangles of one leaf.
double to_leaf(const ObbTree& tree, const OpenNodes<ObbTree>& nodes, OpenBox leaf, const Vector3d& point)
{
    double least = std::numeric_limits<double>::infinity();
    for (const std::uint32_t t : nodes.primitives(leaf.slot, leaf.lane))
        least = std::min(least, squared_distance(point + tree.centre(), tree.corners(t)));
    return std::sqrt(least);
}

TEST(PointSearch, FindsALeafNearlyAsNearAsTheNearest)
{
    for (const Case& c : cases()) {
        ObbTree tree(c.a);
        OpenNodes<ObbTree> nodes;
        for (std::uint64_t seed = 0; seed < 40; ++seed) {
            nodes.start(tree, &at_home);
            nodes.open(ObbTree::root);
            const double far = 3 * tree.radius() * u01(seed, 1, 0);
            const Vector3d place = far * random_pose(seed, 1).linear().col(0);
            const float point[3] = {float(place.x()), float(place.y()), float(place.z())};
            const Vector3d from(point[0], point[1], point[2]);
            const OpenBox leaf = nearest_leaf(nodes, oriented_box_kernel(), point, [&](std::uint32_t t) {
                return squared_distance(from + tree.centre(), tree.corners(t));
            });
            ASSERT_TRUE(nodes[leaf.slot].leaf(leaf.lane)) << c.name;
            double nearest = std::numeric_limits<double>::infinity();
            for (std::uint32_t t = 0; t < c.a.triangles.size(); ++t)
                nearest = std::min(nearest, squared_distance(from + tree.centre(), tree.corners(t)));
            // A leaf that counts by its box has a radius of an eighth of its distance at most.
            EXPECT_LE(to_leaf(tree, nodes, leaf, from), 1.3 * std::sqrt(nearest) + 1e-5 * tree.radius()) << c.name;
        }
    }
}

TEST(PointSearch, FindsNoLeafAtADistanceThatFloatsCannotExpress)
{
    const Mesh box = make_box_mesh({0.5, 0.5, 0.5});
    ObbTree tree(box);
    OpenNodes<ObbTree> nodes;
    nodes.start(tree, &at_home);
    nodes.open(ObbTree::root);
    const float point[3] = {1e30f, 0, 0};
    EXPECT_EQ(nearest_leaf(nodes, oriented_box_kernel(), point, [](std::uint32_t) { return 0.0; }), no_box);
}

/// Between two balls the guess ends at the nearest triangles.
TEST(PointSearch, ApproachesTheNearestPointsOfBalls)
{
    const Mesh ball = make_sphere_mesh(1, 200), small = scaled(ball, 0.3);
    ObbTree a(ball), b(small);
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        Isometry3d pose = random_pose(seed, 1);
        pose.translation() = (1.4 + u01(seed, 3, 0)) * random_pose(seed + 50, 1).linear().col(0);
        const RelativePose b_to_a = at(pose);
        const WalkFrame frame(a, b, b_to_a, std::numeric_limits<double>::infinity());
        OpenNodes<ObbTree> nodes_a, nodes_b;
        nodes_a.start(a, &frame.place_a), nodes_b.start(b, &frame.place_b);
        nodes_a.open(ObbTree::root), nodes_b.open(ObbTree::root);
        const auto moved = [&](std::uint32_t t) {
            TrianglePoints points = b.corners(t);
            for (Vector3d& p : points) p = b_to_a(p);
            return points;
        };
        const auto place = [&](const float(&p)[3]) { return Vector3d(frame.origin + Vector3d(p[0], p[1], p[2])); };
        double nearest = std::numeric_limits<double>::infinity();
        int rounds = 0;
        approach(
            nodes_a, nodes_b, oriented_box_kernel(),
            [&](std::uint32_t t, const auto& p) { return squared_distance(place(p), a.corners(t)); },
            [&](std::uint32_t t, const auto& p) { return squared_distance(place(p), moved(t)); },
            [&](OpenBox of_a, OpenBox of_b, bool in_a, float(&point)[3]) {
                ++rounds;
                const double before = nearest;
                for (const std::uint32_t i : nodes_a.primitives(of_a.slot, of_a.lane))
                    for (const std::uint32_t j : nodes_b.primitives(of_b.slot, of_b.lane)) {
                        const NearestPoints points = nearest_points(a.corners(i), moved(j), 0x1p-40);
                        if (points.distance >= nearest) continue;
                        nearest = points.distance;
                        for (int k = 0; k < 3; ++k) point[k] = float((in_a ? points.a : points.b)[k] - frame.origin[k]);
                    }
                return nearest < before;
            });
        double truth = std::numeric_limits<double>::infinity();
        for (std::uint32_t i = 0; i < ball.triangles.size(); ++i)
            for (std::uint32_t j = 0; j < small.triangles.size(); ++j)
                truth = std::min(truth, triangle_distance(a.corners(i), moved(j)));
        EXPECT_GE(nearest, truth * (1 - 1e-12));
        EXPECT_LE(nearest, 1.05 * truth) << seed;
        EXPECT_LE(rounds, 10);
    }
}

} // namespace
} // namespace oncollide::mesh_cases
