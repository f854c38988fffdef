// Fans of triangles that lie around their vertex without overlap, compared with exact tests of all pairs of triangles.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/exact/neighbours.hpp>
#include <oncollide/narrowphase/self/fan_kernel.hpp>
#include <oncollide/narrowphase/self/spread_fans.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::spread_fans_test {
namespace {

using Eigen::Vector3d;

/// Around vertex 0, over points that `place` gives for their angles.
Mesh fan(int blades, auto place)
{
    std::vector<Vector3d> vertices{Vector3d::Zero()};
    std::vector<Triangle> triangles;
    for (int k = 0; k < blades; ++k) {
        vertices.push_back(place(2 * M_PI * k / blades));
        triangles.push_back({0, static_cast<std::uint32_t>(1 + k), static_cast<std::uint32_t>(1 + (k + 1) % blades)});
    }
    return make_mesh("fan", vertices, triangles);
}

bool is_spread(const Mesh& mesh)
{
    return spread_fans(mesh, 1).front();
}

TEST(SpreadFans, AreFoundAroundMostVertices)
{
    const auto around = [](double angle) { return Vector3d(std::cos(angle), std::sin(angle), 0.5); };
    for (int blades = 3; blades <= 16; ++blades) EXPECT_TRUE(is_spread(fan(blades, around))) << blades;
    for (const int blades : {5, 7, 9, 15}) // pentagrams and the like
        EXPECT_FALSE(is_spread(fan(blades, [&](double angle) { return around(2 * angle); }))) << blades;
    const auto folded = [](double angle) { return Vector3d(std::abs(std::cos(angle)), std::sin(angle), 0); };
    EXPECT_FALSE(is_spread(fan(6, folded)));
    for (const double scale : {1e-14, 1e-200, 1e14}) {
        const Mesh mesh = transformed("fan", fan(6, around), scale, Vector3d::Zero());
        EXPECT_TRUE(is_spread(mesh)) << scale;
    }
    const Mesh sphere = make_sphere_mesh(1, 8000), knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 8000);
    for (const Mesh* mesh : {&sphere, &knot})
        EXPECT_GT(std::ranges::count(spread_fans(*mesh, 1), 1), std::ptrdiff_t(mesh->vertices.size()) - 20);
}

TEST(SpreadFans, AreClosedByEachEdgeOnce)
{
    const auto around = [](double angle) { return Vector3d(std::cos(angle), std::sin(angle), 0.5); };
    const Mesh closed = fan(6, around);
    const auto changed = [&](auto change) {
        Mesh mesh = closed;
        change(mesh.triangles);
        return is_spread(mesh);
    };
    EXPECT_TRUE(changed([](auto& t) { std::swap(t[0], t[3]), std::ranges::rotate(t[2], t[2].begin() + 1); }));
    EXPECT_FALSE(changed([](auto& t) { t.pop_back(); })) << "open";
    EXPECT_FALSE(changed([](auto& t) { t.push_back(t[0]); })) << "a copy";
    EXPECT_FALSE(changed([](auto& t) { t[1] = t[0]; })) << "a copy in place of another one";
    EXPECT_FALSE(changed([](auto& t) { std::swap(t[0][1], t[0][2]); })) << "one is reversed";
    EXPECT_TRUE(changed([](auto& t) {
        for (Triangle& all : t) std::swap(all[1], all[2]);
    })) << "all are reversed";
    EXPECT_FALSE(changed([](auto& t) { t.push_back({0, 0, 1}); })) << "a segment";
    for (std::uint32_t at = 1; at <= 6; ++at) { // a triangle more begins, or ends, at an edge
        const auto one_more = [&](double angle, bool ends) {
            Mesh mesh = closed;
            mesh.vertices.push_back(around((at - 1) * M_PI / 3 + angle));
            mesh.triangles.push_back(ends ? Triangle{0, 7, at} : Triangle{0, at, 7});
            return is_spread(mesh);
        };
        EXPECT_FALSE(one_more(0.5, false)) << at;
        EXPECT_FALSE(one_more(-0.5, true)) << at;
    }
}

/// A fan of random shape, in random order, now and then with faults.
Mesh draw_fan(std::uint64_t seed)
{
    std::uint64_t drawn = 0;
    const auto draw = [&] { return u01(seed, drawn++, 3); };
    const auto below = [&](int n) { return int(draw() * n); };
    const int blades = 3 + below(15), turns = below(4) ? 1 : 2;
    const double noise = 1.5 * draw() * draw(), height = draw() * draw(), lattice = below(3) ? 0 : 0.5;
    Mesh mesh = fan(blades, [&](double angle) {
        angle = turns * (angle + noise * draw());
        Vector3d p = (0.5 + draw()) * Vector3d(std::cos(angle), std::sin(angle), 0);
        p.z() = height * (2 * draw() - 1);
        if (lattice > 0) p = lattice * (p / lattice).array().round().matrix();
        return p;
    });
    const Eigen::AngleAxisd turn(draw() * 7, Vector3d(draw(), draw(), draw() + 0.1).normalized());
    const Vector3d away = below(2) ? Vector3d(Vector3d::Zero()) : Vector3d(1e3 * draw(), 1e3 * draw(), 5);
    for (Vector3d& v : mesh.vertices) v = turn * v + away;
    for (std::size_t k = mesh.triangles.size(); k-- > 1;)
        std::swap(mesh.triangles[k], mesh.triangles[static_cast<std::size_t>(below(int(k) + 1))]);
    for (Triangle& t : mesh.triangles) std::ranges::rotate(t, t.begin() + below(3));
    auto& some = mesh.triangles[static_cast<std::size_t>(below(blades))];
    if (below(10) == 0) some = mesh.triangles[0];
    if (below(10) == 0) std::swap(some[0], some[1]);
    return mesh;
}

TEST(SpreadFans, HaveNoTrianglesThatMeetBeyondTheVertex)
{
    std::size_t spread = 0, apart = 0;
    for (std::uint64_t seed = 0; seed < 30'000; ++seed) {
        const Mesh mesh = draw_fan(seed);
        bool meet = false;
        const auto corners = [&](const Triangle& t) -> TrianglePoints {
            return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
        };
        for (std::size_t s = 0; s < mesh.triangles.size() && !meet; ++s)
            for (std::size_t t = s + 1; t < mesh.triangles.size() && !meet; ++t)
                meet = meet_beyond_shared(corners(mesh.triangles[s]), corners(mesh.triangles[t]));
        const bool found = is_spread(mesh);
        ASSERT_FALSE(found && meet) << "seed " << seed;
        spread += found, apart += !meet;
    }
    EXPECT_GT(spread, 5'000u);
    EXPECT_GT(spread, apart / 2);
}

TEST(SpreadFans, AreTheSameWithAllInstructionSets)
{
    std::vector<SpreadFans*> kernels{baseline::spread_fans_kernel()};
#if defined(__x86_64__) && !defined(ONCOLLIDE_BASELINE_ALONE)
    if (instruction_set() >= InstructionSet::avx2) kernels.push_back(avx2::spread_fans_kernel());
    if (instruction_set() >= InstructionSet::avx512) kernels.push_back(avx512::spread_fans_kernel());
#endif
    for (std::uint64_t seed = 0; seed < 3'000; ++seed) {
        const Mesh mesh = draw_fan(seed);
        std::vector<std::uint32_t> begin(mesh.vertices.size() + 1), first, second;
        for (const Triangle& t : mesh.triangles)
            for (unsigned k = 0; k < 3; ++k)
                if (t[k] == 0) first.push_back(t[(k + 1) % 3]), second.push_back(t[(k + 2) % 3]);
        begin[1] = static_cast<std::uint32_t>(first.size());
        first.resize(first.size() + 16), second.resize(second.size() + 16);
        std::vector<std::uint8_t> found(1);
        for (SpreadFans* const kernel : kernels) {
            kernel({mesh.vertices[0].data(), begin.data(), first.data(), second.data()}, 0, 1, found.data());
            EXPECT_EQ(found[0], is_spread(mesh)) << "seed " << seed;
        }
    }
}

} // namespace
} // namespace oncollide::spread_fans_test
