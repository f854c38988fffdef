// Convex solids around meshes, compared with all vertices, and their gaps, compared with the distance of the meshes.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/hulls/outer_hull.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>
#include <oncollide/samples/generators.hpp>

#include "random_pose.hpp"

namespace oncollide::outer_hull_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

Mesh scaled(const Mesh& mesh, double scale, const Vector3d& by = Vector3d::Zero())
{
    return transformed("scaled", mesh, scale, by / scale);
}

std::vector<Mesh> meshes()
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300), soup = make_soup_mesh(120, 0.5, 1.5, 6);
    return {knot,
            soup,
            make_box_mesh({0.5, 0.1, 2}),
            make_soup_mesh(1, 1, 0.5, 3),
            make_needles_mesh(60, 1, 1e4, 2, 5),
            make_mesh("a flat one", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {1, 3, 2}}),
            make_mesh("a point", {{1, 2, 3}}, {{0, 0, 0}}),
            make_mesh("a vertex that no triangle uses", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {9, 9, 9}}, {{0, 1, 2}}),
            scaled(knot, 1e-9),
            scaled(soup, 1e9),
            scaled(knot, 1e-46),
            scaled(knot, 1, {1e8, -1e8, 1e7})};
}

Vector3d direction(std::uint64_t i)
{
    Vector3d d(u01(5, i, 0) - 0.5, u01(5, i, 1) - 0.5, u01(5, i, 2) - 0.5);
    if (i % 4 == 0) d[i / 4 % 3] = 0;
    return d.normalized();
}

TEST(OuterHull, HoldsEveryTriangle)
{
    for (const Mesh& mesh : meshes()) {
        const OuterHull hull(mesh);
        EXPECT_LE(hull.cover(), mesh.bounds.diagonal() / 64 + 0x1p-148);
        for (std::uint64_t i = 0; i < 500; ++i) {
            const Vector3d d = direction(i);
            double most = -HUGE_VAL;
            for (const Triangle& t : mesh.triangles)
                for (const std::uint32_t v : t) most = std::max(most, d.dot(mesh.vertices[v] - hull.centre()));
            const double shown = d.dot(hull.farthest(d.cast<float>())) + hull.cover();
            EXPECT_GE(shown + 0x1p-19 * hull.extent(), most) << i;
        }
    }
}

TEST(OuterHull, ShowsNoMoreThanTheDistance)
{
    Traversal walk;
    int parted = 0;
    const std::vector<Mesh> all = meshes();
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t k = 0; k <= i; ++k) {
            const Mesh &a = all[i], &b = all[k];
            const OuterHull hull_a(a), hull_b(b);
            ObbTree tree_a(a), tree_b(b);
            const double size = 0.5 * (a.bounds.diagonal() + b.bounds.diagonal());
            for (std::uint64_t j = 0; j < 24; ++j) {
                Isometry3d at_a = random_pose(100 * i + j, 1), at_b = random_pose(7000 * k + j, 1);
                if (j % 3 == 0) at_b.linear() *= 1 + 0x1p-21, at_a.linear() *= 1 - 0x1p-21; // at the limit of rigidity
                const double apart = std::pow(2, double(j % 8) - 5) * size;
                at_b.translation() =
                    at_a * a.bounds.centre() - at_b.linear() * b.bounds.centre() + (0.5 * size + apart) * direction(j);
                const RelativePose b_to_a(at_a, at_b);
                const Vector3f first = j % 2 ? direction(3 * j).cast<float>() : Vector3f(0, 0, 0);
                const HullGap found = hull_gap(hull_a, hull_b, b_to_a, first);
                const auto truth = walk.distance(tree_a, tree_b, b_to_a, 0);
                EXPECT_LE(found.gap, truth.upper) << i << ' ' << k << ' ' << j;
                parted += found.gap > 0;
                if (!(found.gap > 0)) continue;
                // A new search from the found direction succeeds at once.
                const HullGap again = hull_gap(hull_a, hull_b, b_to_a, found.across);
                EXPECT_GE(again.gap, 0.49 * found.gap);
                EXPECT_LE(again.gap, truth.upper);
            }
        }
    EXPECT_GT(parted, 800);
}

TEST(OuterHull, ShowsNearlyTheDistanceOfConvexMeshes)
{
    const Mesh a = make_box_mesh({0.5, 0.1, 2}), b = make_box_mesh({1, 1, 1});
    const OuterHull hull_a(a), hull_b(b);
    ObbTree tree_a(a), tree_b(b);
    Traversal walk;
    for (std::uint64_t j = 0; j < 200; ++j) {
        const Isometry3d at_a = random_pose(j, 0.1), at_b = random_pose(j + 1000, 6);
        const RelativePose b_to_a(at_a, at_b);
        const double truth = walk.distance(tree_a, tree_b, b_to_a, 0).lower;
        const double found = hull_gap(hull_a, hull_b, b_to_a, Vector3f::Zero()).gap;
        EXPECT_GE(found, 0.88 * truth - 0.02) << j;
    }
}

} // namespace
} // namespace oncollide::outer_hull_test
