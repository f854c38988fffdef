// Triangles of one mesh that meet each other, compared with exact tests of all pairs.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/exact/neighbours.hpp>
#include <oncollide/narrowphase/self/self_pairs.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::self_pairs_test {
namespace {

using Eigen::Vector3d;
using Pairs = std::vector<TrianglePair>;

TrianglePoints corners(const Mesh& mesh, std::size_t t)
{
    const auto [a, b, c] = mesh.triangles[t];
    return {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]};
}

Pairs brute_force(const Mesh& mesh)
{
    std::vector<Aabb> boxes(mesh.triangles.size());
    for (std::size_t t = 0; t < boxes.size(); ++t)
        for (const Vector3d& p : corners(mesh, t)) boxes[t].add(p);
    Pairs pairs;
    for (std::uint32_t s = 0; s < boxes.size(); ++s)
        for (std::uint32_t t = s + 1; t < boxes.size(); ++t)
            if (boxes[s].overlaps(boxes[t]) && meet_beyond_shared(corners(mesh, s), corners(mesh, t)))
                pairs.push_back({s, t});
    return pairs;
}

constexpr std::size_t all = std::numeric_limits<std::size_t>::max();

Pairs pairs_of(const Mesh& mesh)
{
    return self_pairs(mesh, all, 1);
}

/// A square of n x n cells, folded, crumpled or flat, whose vertices `place` gives for cell corners (i, j).
Mesh square(int n, auto place)
{
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) vertices.push_back(place(i, j));
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const auto at = static_cast<std::uint32_t>(j * (n + 1) + i), up = at + static_cast<std::uint32_t>(n) + 1;
            triangles.push_back({at, at + 1, up + 1}), triangles.push_back({at, up + 1, up});
        }
    return make_mesh("square", vertices, triangles);
}

/// The same triangles, each with vertices of its own.
Mesh unwelded(const Mesh& mesh)
{
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        for (const Vector3d& p : corners(mesh, t)) vertices.push_back(p);
        triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    return make_mesh("unwelded", vertices, triangles);
}

/// Folded, crumpled and random meshes of few triangles, most with coordinates on a small lattice: then corners lie on
/// edges and faces, faces in one plane, and triangles coincide or have no area.
Mesh draw_mesh(std::uint64_t seed)
{
    std::uint64_t drawn = 0;
    const auto draw = [&] { return u01(seed, drawn++, 3); };
    const auto below = [&](int n) { return int(draw() * n); };
    const int family = below(4), range = 2 + below(4);
    const auto lattice = [&] { return Vector3d{double(below(range)), double(below(range)), double(below(range))}; };
    const auto fold = [&](int i) { return std::abs((i + 2) % 4 - 2); };
    Mesh mesh;
    switch (family) {
    case 0: { // any triangles of a few vertices
        std::vector<Vector3d> vertices(static_cast<std::size_t>(4 + below(6)));
        for (Vector3d& v : vertices) v = lattice();
        std::vector<Triangle> triangles(static_cast<std::size_t>(2 + below(14)));
        for (Triangle& t : triangles)
            for (std::uint32_t& v : t) v = static_cast<std::uint32_t>(below(static_cast<int>(vertices.size())));
        mesh = make_mesh("any", vertices, triangles);
        break;
    }
    case 1: // folded along lines of the lattice; some vertices are moved
        mesh = square(2 + below(2), [&](int i, int j) {
            return Vector3d{double(fold(i)), double(below(3) ? fold(j) : j), double(below(4) ? 0 : below(2))};
        });
        break;
    case 2: // crumpled
        mesh = square(2 + below(3), [&](int i, int j) {
            const double noise = 2 * u01(seed, 0, 4);
            return Vector3d{i + noise * draw(), j + noise * draw(), noise * draw()};
        });
        break;
    default: // fans around a vertex
        std::vector<Vector3d> vertices{Vector3d::Zero()};
        std::vector<Triangle> triangles;
        const int blades = 3 + below(8);
        for (int k = 0; k < blades; ++k) vertices.push_back(2 * lattice() - Vector3d::Constant(range - 1));
        for (int k = 0; k < blades; ++k)
            triangles.push_back(
                {0, static_cast<std::uint32_t>(1 + k), static_cast<std::uint32_t>(1 + (k + 1) % blades)});
        mesh = make_mesh("fan", vertices, triangles);
    }
    const double scales[] = {1, 0x1p-30, 0x1p30, 1e-9, 1e9, 1e-3};
    return transformed("drawn", mesh, scales[below(6)], below(3) ? Vector3d(0, 0, 0) : Vector3d(-1000, 300, 0.1));
}

TEST(SelfPairs, AreThoseOfBruteForceInRandomMeshes)
{
    std::size_t pairs = 0, alone = 0;
    for (std::uint64_t seed = 0; seed < 40'000; ++seed) {
        const Mesh mesh = draw_mesh(seed);
        const Pairs truth = brute_force(mesh);
        ASSERT_EQ(pairs_of(mesh), truth) << "seed " << seed;
        if (seed % 4 == 0) {
            ASSERT_EQ(pairs_of(unwelded(mesh)), truth) << "seed " << seed << ", unwelded";
        }
        pairs += truth.size(), alone += truth.empty();
    }
    EXPECT_GT(pairs, 100'000u);
    EXPECT_GT(alone, 3'000u);
}

/// Large enough for several parts of the search.
TEST(SelfPairs, AreThoseOfBruteForceInLargeMeshes)
{
    const auto crumple = [](double by) {
        return [by](int i, int j) {
            const auto k = static_cast<std::uint64_t>(1000 * j + i);
            return Vector3d(i + by * u01(1, k, 0), j + by * u01(1, k, 1), by * u01(1, k, 2));
        };
    };
    const std::pair<const char*, Mesh> meshes[] = {
        {"a knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 6000)},
        {"a knot through itself", make_torus_knot_mesh(3, 7, 1, 0.4, 0.35, 6000)},
        {"triangles at random", make_soup_mesh(3000, 0.2, 1.5, 1)},
        {"crumpled", square(55, crumple(1.5))},
        {"nearly flat", square(55, crumple(0.3))},
        {"folded once", square(50, [](int i, int j) { return Vector3d(std::abs(i - 25), j, 0.01 * (i > 25)); })},
        {"rolled up", square(60, [](int i, int j) {
             const double turn = 0.3 * i;
             return Vector3d((1 + 0.01 * turn) * std::cos(turn), (1 + 0.01 * turn) * std::sin(turn), 0.03 * j);
         })}};
    for (const auto& [name, mesh] : meshes) {
        const Pairs truth = brute_force(mesh);
        EXPECT_EQ(pairs_of(mesh), truth) << name;
        EXPECT_EQ(pairs_of(unwelded(mesh)), truth) << name << ", unwelded";
    }
    EXPECT_TRUE(pairs_of(meshes[0].second).empty());
    EXPECT_FALSE(pairs_of(meshes[1].second).empty());
}

TEST(SelfPairs, DoNotDependOnThreadsAndEndAtTheLimit)
{
    const Mesh mesh = make_soup_mesh(10'000, 0.1, 1.5, 2);
    const Pairs pairs = pairs_of(mesh);
    EXPECT_EQ(self_pairs(mesh, all, 3), pairs);
    for (const std::size_t most : {std::size_t{0}, std::size_t{1}, std::size_t{1000}, pairs.size(), pairs.size() + 1}) {
        const Pairs some = self_pairs(mesh, most, 3);
        EXPECT_EQ(some.size(), std::min(most, pairs.size()));
        EXPECT_TRUE(std::ranges::includes(pairs, some));
        EXPECT_EQ(self_pairs(mesh, most, 1), some);
    }
}

struct NamedCase {
    const char* name;
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    Pairs pairs;
};

/// The rule, case by case.
std::vector<NamedCase> named_cases()
{
    const Vector3d o{0, 0, 0}, x{4, 0, 0}, y{0, 4, 0}, z{0, 0, 4}, xy{4, 4, 0};
    return {
        {"one triangle", {o, x, y}, {{0, 1, 2}}, {}},
        {"far apart", {o, x, y, {0, 0, 9}, {4, 0, 9}, {0, 4, 9}}, {{0, 1, 2}, {3, 4, 5}}, {}},
        {"neighbours in one plane share an edge", {o, x, y, xy}, {{0, 1, 2}, {1, 3, 2}}, {}},
        {"neighbours at an angle share an edge", {o, x, y, z}, {{0, 1, 2}, {0, 1, 3}}, {}},
        {"folded flat onto the neighbour", {o, x, y, {1, 1, 0}}, {{0, 1, 2}, {0, 1, 3}}, {{0, 1}}},
        {"folded flat across the neighbour", {o, x, y, xy}, {{0, 1, 2}, {0, 1, 3}}, {{0, 1}}},
        {"folded nearly flat", {o, x, y, {1, 1, 1e-300}}, {{0, 1, 2}, {0, 1, 3}}, {}},
        {"neighbours share a corner", {o, x, y, -x, -y}, {{0, 1, 2}, {0, 3, 4}}, {}},
        {"an edge through the neighbour's face leaves their corner",
         {o, x, y, {1, 1, -1}, {1, 1, 1}},
         {{0, 1, 2}, {0, 3, 4}},
         {{0, 1}}},
        {"an edge on the neighbour's edge", {o, x, y, {2, 0, 0}, z}, {{0, 1, 2}, {0, 3, 4}}, {{0, 1}}},
        {"overlap in one plane at a common corner", {o, x, y, {1, 1, 0}, {9, 9, 0}}, {{0, 1, 2}, {0, 3, 4}}, {{0, 1}}},
        {"a corner on a face", {o, x, y, {1, 1, 0}, {1, 1, 2}, {2, 1, 2}}, {{0, 1, 2}, {3, 4, 5}}, {{0, 1}}},
        {"a corner inside an edge", {o, x, y, {2, 0, 0}, {2, -1, 2}, {3, -1, 2}}, {{0, 1, 2}, {3, 4, 5}}, {{0, 1}}},
        {"an edge of three triangles", {o, x, y, z, -y}, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}, {}},
        {"two copies", {o, x, y}, {{0, 1, 2}, {0, 1, 2}}, {{0, 1}}},
        {"a copy with its back to the first", {o, x, y}, {{0, 1, 2}, {1, 0, 2}}, {{0, 1}}},
        {"a copy with vertices of its own", {o, x, y, o, x, y}, {{0, 1, 2}, {4, 5, 3}}, {{0, 1}}},
        {"three copies", {o, x, y}, {{0, 1, 2}, {1, 2, 0}, {2, 1, 0}}, {{0, 1}, {0, 2}, {1, 2}}},
        {"an edge with vertices of its own", {o, x, y, o, x, z}, {{0, 1, 2}, {3, 4, 5}}, {}},
        {"a vertex of its own at the common edge's other end", {o, x, y, x, z}, {{0, 1, 2}, {0, 3, 4}}, {}},
        {"vertices at 0 and at -0", {o, x, y, {-0.0, -0.0, -0.0}, -x, z}, {{0, 1, 2}, {3, 4, 5}}, {}},
        {"a vertex one bit from the corner", {o, x, y, {0, 0, 0x1p-1074}, -x, z}, {{0, 1, 2}, {3, 4, 5}}, {}},
        {"a vertex one bit into the face", {o, x, y, {0x1p-50, 0x1p-50, 0}, -x, z}, {{0, 1, 2}, {3, 4, 5}}, {{0, 1}}},
        {"a segment on its neighbour's edge", {o, x, y}, {{0, 1, 2}, {0, 1, 1}}, {}},
        {"a segment that closes a T",
         {o, x, y, {2, 0, 0}, -y},
         {{0, 1, 2}, {0, 3, 1}, {0, 4, 3}, {3, 4, 1}},
         {{0, 2}, {0, 3}}},
        {"a segment through a face", {o, x, y, {1, 1, -1}, {1, 1, 1}}, {{0, 1, 2}, {3, 4, 4}}, {{0, 1}}},
        {"a segment into the neighbour's face", {o, x, y, {1, 1, 0}}, {{0, 1, 2}, {0, 3, 3}}, {{0, 1}}},
        {"a segment along and beyond the neighbour's edge", {o, x, y, {9, 0, 0}}, {{0, 1, 2}, {0, 3, 3}}, {{0, 1}}},
        {"a segment away from the corner", {o, x, y, {-1, -1, 0}}, {{0, 1, 2}, {0, 3, 3}}, {}},
        {"a segment whose middle is the corner", {o, x, y, {-1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}, {3, 0, 4}}, {{0, 1}}},
        {"a point that is a corner", {o, x, y}, {{0, 1, 2}, {1, 1, 1}}, {}},
        {"a point on a face", {o, x, y, {1, 1, 0}}, {{0, 1, 2}, {3, 3, 3}}, {{0, 1}}},
        {"two segments that overlap", {o, {2, 0, 0}, x, {6, 0, 0}}, {{0, 2, 2}, {1, 3, 3}}, {{0, 1}}},
        {"two segments on a line, end to end", {o, x, {6, 0, 0}}, {{0, 1, 1}, {1, 2, 2}}, {}},
        {"two segments from one end", {o, x, {6, 0, 0}}, {{0, 1, 1}, {0, 2, 2}}, {{0, 1}}},
        {"two copies of a segment", {o, x}, {{0, 1, 1}, {1, 0, 0}}, {}},
        {"two points", {o}, {{0, 0, 0}, {0, 0, 0}}, {}},
    };
}

TEST(SelfPairs, FollowTheRuleInNamedCases)
{
    for (const NamedCase& c : named_cases())
        for (const double scale : {1.0, 1e-9, 0x1p-40, 1e9}) {
            const Mesh mesh = transformed(c.name, make_mesh(c.name, c.vertices, c.triangles), scale, Vector3d::Zero());
            EXPECT_EQ(pairs_of(mesh), c.pairs) << c.name << ", times " << scale;
            EXPECT_EQ(pairs_of(unwelded(mesh)), c.pairs) << c.name << ", unwelded, times " << scale;
        }
}

} // namespace
} // namespace oncollide::self_pairs_test
