// Large meshes split by a grid: the parts, and the tree that is made from them.
#include <algorithm>
#include <numeric>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include <oncollide/narrowphase/obb/fits/grid_split.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>
#include <oncollide/samples/generators.hpp>

#include "random_pose.hpp"

namespace oncollide {
namespace {

using Eigen::Vector3d;

struct Large {
    const char* name;
    Mesh mesh;
};

Mesh joined(Mesh a, const Mesh& b)
{
    const auto first = static_cast<std::uint32_t>(a.vertices.size());
    a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (const Triangle& t : b.triangles) a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    return make_mesh("joined", std::move(a.vertices), std::move(a.triangles));
}

const std::vector<Large>& large_meshes()
{
    static const std::vector<Large> all = [] {
        std::vector<Large> meshes;
        meshes.push_back({"terrain", make_terrain_mesh(300, 20, 280, 5)});
        meshes.push_back({"knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 140'000)});
        Mesh far = make_soup_mesh(1, 1, 1, 3);
        for (Vector3d& v : far.vertices) v += Vector3d(1e7, -1e6, 3e5);
        meshes.push_back({"one far away", joined(make_soup_mesh(135'000, 0.1, 10, 4), far)});
        const std::vector<Triangle> same(140'000, Triangle{0, 1, 2});
        meshes.push_back({"all the same", make_mesh("same", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, same)});
        const std::vector<Triangle> point(140'000, Triangle{0, 0, 0});
        meshes.push_back({"a point", make_mesh("point", {{3, 4, 5}}, point)});
        return meshes;
    }();
    return all;
}

std::vector<std::uint32_t> numbers(const Mesh& mesh)
{
    std::vector<std::uint32_t> all(mesh.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

TEST(GridSplit, TellsEveryTriangleApartOnceInBoxesThatHoldIt)
{
    for (const auto& [name, each] : large_meshes()) {
        const Mesh& mesh = each; // Clang 14 lets no lambda capture a structured binding
        SCOPED_TRACE(name);
        std::vector<std::uint32_t> order = numbers(mesh);
        const Vector3d centre = mesh.bounds.centre(), half = mesh.bounds.half_extent();
        const GridPart all = split_by_grid(mesh, centre, order, {-half, half});
        EXPECT_EQ(all.count, order.size());
        std::vector<std::uint32_t> sorted = order;
        std::ranges::sort(sorted);
        EXPECT_EQ(sorted, numbers(mesh)) << "each once";
        std::size_t last = 0;
        const auto look = [&](const auto& self, const GridPart& part) -> void {
            EXPECT_GT(part.count, 0u);
            EXPECT_NE(part.parts.size(), 1u);
            EXPECT_LE(part.parts.size(), 8u);
            std::uint32_t next = part.begin;
            for (const GridPart& one : part.parts) {
                EXPECT_EQ(one.begin, next);
                next += one.count;
                EXPECT_TRUE(part.box.contains(one.box));
                self(self, one);
            }
            if (!part.parts.empty()) {
                EXPECT_EQ(next, part.begin + part.count);
                return;
            }
            EXPECT_EQ(part.begin, last);
            last = part.begin + part.count;
            for (std::uint32_t i = part.begin; i < part.begin + part.count; ++i)
                for (std::uint32_t v : mesh.triangles[order[i]]) {
                    const Vector3d p = mesh.vertices[v] - centre;
                    ASSERT_TRUE(part.box.contains({p, p}));
                }
        };
        look(look, all);
        EXPECT_EQ(last, order.size());
    }
}

TEST(GridSplit, PartsOfASurfaceAreAboutEquallyLarge)
{
    for (std::size_t k : {0u, 1u}) {
        const Mesh& mesh = large_meshes()[k].mesh;
        std::vector<std::uint32_t> order = numbers(mesh);
        const Vector3d half = mesh.bounds.half_extent();
        const GridPart all = split_by_grid(mesh, mesh.bounds.centre(), order, {-half, half});
        ASSERT_EQ(all.parts.size(), 8u) << large_meshes()[k].name;
        for (const GridPart& part : all.parts) {
            EXPECT_GT(part.count, all.count / 16);
            EXPECT_LT(part.count, all.count / 4);
        }
    }
}

/// Contents and extent of a box must not depend on the order in the file.
TEST(GridSplit, PartsDoNotDependOnTheOrderOfTheTriangles)
{
    const Mesh& mesh = large_meshes()[1].mesh;
    const Vector3d half = mesh.bounds.half_extent();
    std::vector<std::uint32_t> order = numbers(mesh), shuffled = order;
    std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(3));
    const GridPart a = split_by_grid(mesh, mesh.bounds.centre(), order, {-half, half});
    const GridPart b = split_by_grid(mesh, mesh.bounds.centre(), shuffled, {-half, half});
    const auto same = [&](const auto& self, const GridPart& x, const GridPart& y) -> void {
        ASSERT_EQ(x.parts.size(), y.parts.size());
        EXPECT_EQ(x.begin, y.begin);
        EXPECT_EQ(x.box.min, y.box.min);
        EXPECT_EQ(x.box.max, y.box.max);
        for (std::size_t k = 0; k < x.parts.size(); ++k) self(self, x.parts[k], y.parts[k]);
        if (!x.parts.empty()) return;
        const auto of = [&](const std::vector<std::uint32_t>& list) {
            return std::set<std::uint32_t>(list.begin() + x.begin, list.begin() + x.begin + x.count);
        };
        EXPECT_EQ(of(order), of(shuffled));
    };
    same(same, a, b);
}

TEST(GridSplit, ATreeOfALargeMeshHoldsEveryTriangleInEachOfItsBoxes)
{
    for (const auto& [name, mesh] : large_meshes()) {
        SCOPED_TRACE(name);
        ObbTree tree(mesh);
        std::vector<std::uint8_t> seen(mesh.triangles.size());
        OpenBoxes boxes;
        for (std::vector<ObbTree::Node> open{ObbTree::root}; !open.empty();) {
            const ObbTree::Node index = open.back();
            open.pop_back();
            tree.open(index, nullptr, boxes);
            const unsigned lanes = tree.node(index).lanes;
            for (unsigned k = 0; k < lanes; ++k) {
                const std::uint32_t count = tree.count_of(index, k), begin = tree.begin_of(index, k);
                if (count > 64) // smaller parts are split as in small meshes
                    open.push_back(tree.child(index, k));
                else
                    for (std::uint32_t i = begin; i < begin + count; ++i) ++seen[tree.triangle(i)];
                for (std::uint32_t i = begin; i < begin + count; i += 1 + count / 50)
                    for (std::uint32_t v : mesh.triangles[tree.triangle(i)]) {
                        const Vector3d d =
                            mesh.vertices[v] - tree.centre() - Vector3d(boxes.c[0][k], boxes.c[1][k], boxes.c[2][k]);
                        for (int axis = 0; axis < 3; ++axis) {
                            const Vector3d along(boxes.axis[axis][0][k], boxes.axis[axis][1][k],
                                                 boxes.axis[axis][2][k]);
                            ASSERT_LE(std::abs(along.dot(d)), boxes.h[axis][k] + 1e-5 * tree.radius());
                        }
                    }
            }
        }
        EXPECT_TRUE(std::ranges::all_of(seen, [](std::uint8_t times) { return times == 1; }));
        EXPECT_LE(tree.nodes(), ObbTree::most_nodes(mesh.triangles.size()));
        EXPECT_LE(tree.bytes(), ObbTree::most_bytes(mesh.triangles.size()));
    }
}

TEST(GridSplit, ALargeMeshMeetsWhatItsTrianglesMeet)
{
    const Mesh& knot = large_meshes()[1].mesh;
    const Mesh small = make_box_mesh({0.02, 0.03, 0.01});
    ObbTree a(knot), b(small);
    Traversal walk;
    int met = 0, apart = 0;
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
        Eigen::Isometry3d pose = random_pose(seed, 1.2);
        if (seed % 2) pose.translation() = knot.vertices[seed * 1009];
        const RelativePose b_to_a(Eigen::Isometry3d::Identity(), pose);
        std::vector<TrianglePair> found, truth;
        walk.all_meeting(a, b, b_to_a, found);
        for (std::uint32_t t = 0; t < small.triangles.size(); ++t) {
            TrianglePoints p;
            for (std::size_t k = 0; k < 3; ++k) p[k] = b_to_a(small.vertices[small.triangles[t][k]]);
            Aabb box;
            for (const Vector3d& v : p) box.add(v);
            for (std::uint32_t i = 0; i < knot.triangles.size(); ++i) {
                const Triangle& s = knot.triangles[i];
                const TrianglePoints q{knot.vertices[s[0]], knot.vertices[s[1]], knot.vertices[s[2]]};
                Aabb other;
                for (const Vector3d& v : q) other.add(v);
                if (other.overlaps(box) && triangles_meet(q, p)) truth.push_back({i, t});
            }
        }
        std::ranges::sort(truth);
        EXPECT_EQ(found, truth) << seed;
        const RelativePose a_to_b(pose, Eigen::Isometry3d::Identity());
        walk.all_meeting(b, a, a_to_b, found);
        EXPECT_EQ(found.size(), truth.size()) << seed;
        for (const auto& [t, i] : found) EXPECT_TRUE(std::ranges::count(truth, TrianglePair{i, t})) << seed;
        // Distances are found from the roots.
        const double distance = walk.distance(a, b, b_to_a, 1e-9).upper;
        EXPECT_EQ(distance == 0, !truth.empty()) << seed;
        EXPECT_LE(walk.first_meeting(a, b, b_to_a).bound, distance) << seed;
        EXPECT_LE(walk.first_meeting(b, a, a_to_b).bound, distance) << seed;
        for (const double share : {0.9, 1.1}) {
            EXPECT_EQ(walk.near(a, b, b_to_a, share * distance, 0).near, share > 1 || distance == 0) << seed;
            EXPECT_EQ(walk.near(b, a, a_to_b, share * distance, 0).near, share > 1 || distance == 0) << seed;
        }
        (truth.empty() ? apart : met) += 1;
    }
    EXPECT_GT(met, 5);
    EXPECT_GT(apart, 5);
}

} // namespace
} // namespace oncollide
