// Features of one mesh that are near each other, compared with tests of all features.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/exact/exact_nearest.hpp>
#include <oncollide/narrowphase/inside/mesh_links.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/feature_bits.hpp>
#include <oncollide/narrowphase/self/self_near.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::self_near_test {
namespace {

using Eigen::Vector3d;
using Vertices = std::vector<std::uint32_t>; ///< of a feature

/// All vertices, edges and faces of a mesh, by their bits, and the number of edges between its vertices.
struct Features {
    const Mesh& mesh;
    std::vector<std::uint32_t> vertex;
    std::map<FeatureBits, Vertices> all;
    std::vector<std::vector<int>> between;

    explicit Features(const Mesh& of) : mesh(of), vertex(links_of(of).vertex)
    {
        const std::size_t count = mesh.vertices.size();
        between.assign(count, std::vector<int>(count, 1000));
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            Vertices v;
            for (const std::uint32_t k : mesh.triangles[t]) v.push_back(vertex[k]);
            all[face_feature(t)] = v;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t from = v[k], to = v[(k + 1) % 3];
                all[vertex_feature(from)] = {from};
                if (from != to) all[edge_feature(from, to)] = {from, to};
                between[from][from] = 0, between[from][to] = between[to][from] = from != to;
            }
        }
        for (std::size_t k = 0; k < count; ++k)
            for (std::size_t i = 0; i < count; ++i)
                for (std::size_t j = 0; j < count; ++j)
                    between[i][j] = std::min(between[i][j], between[i][k] + between[k][j]);
    }
    int edges_between(FeatureBits a, FeatureBits b) const
    {
        int least = 1000;
        for (const std::uint32_t v : all.at(a))
            for (const std::uint32_t w : all.at(b)) least = std::min(least, between[v][w]);
        return least;
    }
};

/// The nearest features of a vertex and a face, or of two edges, in integers.
struct NearestInIntegers {
    Vertices a, b;
    double distance;
    bool at_border; ///< the nearest points are so near a border that rounding may decide which feature they are on
};

NearestInIntegers nearest_of(const std::vector<Vector3d>& at, const Vertices& a, const Vertices& b)
{
    if (a.size() == 1) {
        const ExactOnTriangle on = exact_nearest_on({at[b[0]], at[b[1]], at[b[2]]}, at[a[0]]);
        Vertices of_b;
        for (std::size_t k = 0; k < 3; ++k)
            if (on.nearest.corners >> k & 1) of_b.push_back(b[k]);
        bool border = false; // near an edge or a corner that the point is not on
        for (std::size_t k = 0; k < 3; ++k) {
            const Vector3d &p = at[b[k]], &q = at[b[(k + 1) % 3]];
            const double length = (q - p).norm(), away = (q - p).cross(on.nearest.at - p).norm() / length;
            const bool on_edge = !(on.nearest.corners >> (k + 2) % 3 & 1);
            border |= !on_edge && away < 1e-6 * length;
            const double from = (on.nearest.at - p).norm();
            border |= from < 1e-6 * length && on.nearest.corners != 1u << k;
        }
        return {a, of_b, on.distance, border};
    }
    const NearestOfSegments n = exact_nearest_of_segments(at[a[0]], at[a[1]], at[b[0]], at[b[1]]);
    const auto of = [](const Vertices& v, double s) { return s <= 0 ? Vertices{v[0]} : s >= 1 ? Vertices{v[1]} : v; };
    const auto border = [](double s) { return (s > 0 && s < 1e-6) || (s < 1 && s > 1 - 1e-6); };
    return {of(a, n.s), of(b, n.t), n.distance, border(n.s) || border(n.t)};
}

FeatureBits bits_of(const Features& features, const Vertices& of, std::uint32_t face)
{
    return of.size() == 1   ? vertex_feature(of[0])
           : of.size() == 2 ? edge_feature(of[0], of[1])
                            : (static_cast<void>(features), face_feature(face));
}

using BitsPair = std::pair<FeatureBits, FeatureBits>;

/// Pairs that self_near() must list, and more pairs that it may list, where rounding decides.
struct Expected {
    std::map<BitsPair, double> must;
    std::set<BitsPair> may;
};

Expected expected(const Features& features, double dhat, int rings)
{
    std::vector<std::pair<FeatureBits, Vertices>> all(features.all.begin(), features.all.end());
    Expected result;
    const auto try_both = [&](const std::pair<FeatureBits, Vertices>& a, const std::pair<FeatureBits, Vertices>& b) {
        for (const std::uint32_t v : a.second)
            if (std::ranges::find(b.second, v) != b.second.end()) return; // their distance is 0 there
        const NearestInIntegers n = nearest_of(features.mesh.vertices, a.second, b.second);
        if (n.distance > dhat * (1 + 1e-9)) return;
        const FeatureBits x = bits_of(features, n.a, 0),
                          y = bits_of(features, n.b, static_cast<std::uint32_t>(b.first & 0xffffffff));
        if (features.edges_between(x, y) < rings) return;
        const BitsPair pair = std::minmax(x, y);
        result.may.insert(pair);
        if (!n.at_border) {
            const auto known = result.must.try_emplace(pair, n.distance).first;
            known->second = std::min(known->second, n.distance);
        }
    };
    for (const auto& a : all)
        for (const auto& b : all) {
            if (a.second.size() == 1 && b.second.size() == 3) try_both(a, b);
            if (a.second.size() == 2 && b.second.size() == 2 && a.first < b.first) try_both(a, b);
        }
    return result;
}

Mesh crumpled(int n, std::uint64_t seed)
{
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    std::uint64_t drawn = 0;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
            const auto draw = [&] { return u01(seed, drawn++, 5); };
            const double z = draw(), y = draw(), x = draw(); // compilers evaluate arguments in any order
            vertices.emplace_back(0.5 * i + x, 0.5 * j + y, z);
        }
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const auto at = static_cast<std::uint32_t>(j * (n + 1) + i), up = at + static_cast<std::uint32_t>(n) + 1;
            triangles.push_back({at, at + 1, up + 1}), triangles.push_back({at, up + 1, up});
        }
    return make_mesh("crumpled", vertices, triangles);
}

std::vector<NearFeatures> near_of(const Mesh& mesh, double dhat, SelfNearOptions rule = {}, int threads = 1)
{
    return self_near(mesh, links_of(mesh).vertex, dhat, rule, threads);
}

void expect_all(const Mesh& mesh, double dhat, std::uint32_t rings, std::size_t& total)
{
    const Features features(mesh);
    const Expected truth = expected(features, dhat, static_cast<int>(rings));
    const std::vector<NearFeatures> found = near_of(mesh, dhat, {.rings = rings});
    std::map<BitsPair, const NearFeatures*> listed;
    for (const NearFeatures& f : found) {
        EXPECT_LT(f.a, f.b);
        EXPECT_TRUE(listed.emplace(BitsPair(f.a, f.b), &f).second) << "listed twice";
        EXPECT_GE(features.edges_between(f.a, f.b), static_cast<int>(rings));
        EXPECT_NEAR((f.point_a - f.point_b).norm(), 0.5 * (f.lower + f.upper), 1e-9);
        EXPECT_LE(f.lower, dhat);
        EXPECT_TRUE(truth.may.contains({f.a, f.b}) || f.upper < 1e-9) << "a pair that is not near";
    }
    for (const auto& [pair, distance] : truth.must) {
        if (distance > dhat * (1 - 1e-9) || distance < 1e-9) continue;
        const auto at = listed.find(pair);
        if (at == listed.end()) {
            ADD_FAILURE() << "lost: " << std::hex << pair.first << ", " << pair.second << ", " << distance;
            continue;
        }
        EXPECT_LE(at->second->lower, distance);
        EXPECT_GE(at->second->upper, distance - 1e-12);
        ++total;
    }
}

TEST(SelfNear, FindsAllThatIntegersFind)
{
    std::size_t total = 0;
    for (std::uint64_t seed = 0; seed < 120; ++seed) {
        const Mesh mesh = crumpled(2 + int(seed % 3), seed);
        for (const std::uint32_t rings : {1u, 2u, 3u}) expect_all(mesh, 0.1 + 0.3 * u01(seed, 1, 1), rings, total);
    }
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.2, 200);
    for (const std::uint32_t rings : {1u, 2u}) expect_all(knot, 0.3, rings, total);
    EXPECT_GT(total, 5000u);
}

TEST(SelfNear, TakesVerticesAtOnePositionForOne)
{
    const Mesh mesh = crumpled(3, 7);
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        for (const std::uint32_t v : mesh.triangles[t]) vertices.push_back(mesh.vertices[v]);
        triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    const Mesh unwelded = make_mesh("unwelded", vertices, triangles);
    const auto welded_found = near_of(mesh, 0.5), found = near_of(unwelded, 0.5);
    EXPECT_GT(found.size(), 20u);
    EXPECT_EQ(found.size(), welded_found.size());
    for (const std::uint32_t rings : {2u, 3u})
        EXPECT_EQ(near_of(unwelded, 0.5, {.rings = rings}).size(), near_of(mesh, 0.5, {.rings = rings}).size());
}

TEST(SelfNear, LeavesOutWhatIsNearInTheRestShape)
{
    // A strip of squares, rolled up to two turns that are 0.1 apart.
    std::vector<Vector3d> flat, rolled;
    std::vector<Triangle> triangles;
    constexpr int n = 60;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j < 2; ++j) {
            const double turn = 4 * M_PI * i / n, radius = 1 + 0.1 * turn / (2 * M_PI);
            flat.emplace_back(0.2 * i, 0.2 * j, 0);
            rolled.emplace_back(radius * std::cos(turn), 0.2 * j, radius * std::sin(turn));
        }
    for (std::uint32_t i = 0; i < n; ++i)
        triangles.push_back({2 * i, 2 * i + 1, 2 * i + 3}), triangles.push_back({2 * i, 2 * i + 3, 2 * i + 2});
    const Mesh mesh = make_mesh("roll", rolled, triangles);
    const auto all = near_of(mesh, 0.25), apart = near_of(mesh, 0.25, {.rest = flat, .rest_distance = 0.5});
    EXPECT_GT(apart.size(), 100u);
    EXPECT_LT(apart.size(), all.size());
    // Exactly the features that are a turn apart are left.
    const Features features(mesh);
    const auto place = [&](FeatureBits of) { return flat[features.all.at(of)[0]].x(); };
    std::size_t far = 0;
    for (const NearFeatures& f : all) far += std::abs(place(f.a) - place(f.b)) > 3;
    EXPECT_EQ(far, apart.size());
    for (const NearFeatures& f : apart) EXPECT_GT(std::abs(place(f.a) - place(f.b)), 3) << f.lower;
}

TEST(SelfNear, DoesNotDependOnThreads)
{
    const Mesh mesh = make_torus_knot_mesh(3, 7, 1, 0.4, 0.35, 12'000);
    const auto found = near_of(mesh, 0.02), again = near_of(mesh, 0.02, {}, 3);
    ASSERT_GT(found.size(), 5000u);
    ASSERT_EQ(found.size(), again.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(std::pair(found[i].a, found[i].b), std::pair(again[i].a, again[i].b));
        EXPECT_EQ(found[i].lower, again[i].lower);
        EXPECT_EQ(found[i].point_a, again[i].point_a);
    }
}

} // namespace
} // namespace oncollide::self_near_test
