// Meshes that rounding has opened are closed, and others stay as they are.
#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/inside/point_location.hpp>
#include <oncollide/samples/generators.hpp>

#include "clash/parts/mended_mesh.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

/// Every triangle with vertices of its own, each moved by less than `by`.
Mesh loosened(const Mesh& mesh, double by, std::uint64_t seed)
{
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (const Triangle& t : mesh.triangles) {
        const auto first = std::uint32_t(vertices.size());
        for (const std::uint32_t v : t) {
            Vector3d way;
            for (std::uint64_t k = 0; k < 3; ++k) way[int(k)] = u01(seed, vertices.size(), k) - 0.5;
            vertices.push_back(mesh.vertices[v] + by * way.normalized() * 0.99);
        }
        triangles.push_back({first, first + 1, first + 2});
    }
    return make_mesh("loose", std::move(vertices), std::move(triangles));
}

/// Some triangles divided in the middle of an edge, which their neighbours do not know; the middle is moved by `by`.
Mesh with_corners_on_edges(Mesh mesh, double by, std::uint64_t seed)
{
    const std::size_t count = mesh.triangles.size();
    for (std::size_t t = 0; t < count; ++t) {
        if (u01(seed, t, 0) < 0.5) continue;
        const auto [a, b, c] = mesh.triangles[t];
        const auto middle = std::uint32_t(mesh.vertices.size());
        const double at = 0.2 + 0.6 * u01(seed, t, 1);
        mesh.vertices.push_back((1 - at) * mesh.vertices[a] + at * mesh.vertices[b] +
                                by * Vector3d::Ones().normalized());
        mesh.triangles[t] = {a, middle, c};
        mesh.triangles.push_back({middle, b, c});
    }
    return make_mesh("divided", std::move(mesh.vertices), std::move(mesh.triangles));
}

Mesh with_some_turned(Mesh mesh, std::uint64_t seed)
{
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (u01(seed, 9, t) < 0.4) std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
    return mesh;
}

Mesh both(const Mesh& a, const Mesh& b, const Vector3d& by = Vector3d::Zero())
{
    std::vector<Vector3d> vertices = a.vertices;
    std::vector<Triangle> triangles = a.triangles;
    for (const Vector3d& v : b.vertices) vertices.push_back(v + by);
    const auto first = std::uint32_t(a.vertices.size());
    for (const Triangle& t : b.triangles) triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    return make_mesh("both", std::move(vertices), std::move(triangles));
}

double volume_of(const Mesh& mesh)
{
    double volume = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto [a, b, c] = corners_of(mesh, t);
        volume += a.dot(b.cross(c)) / 6;
    }
    return volume;
}

constexpr double distance = 1e-5;

TEST(MendedMesh, ClosesWhatRoundingHasOpened)
{
    const Mesh meshes[] = {make_box_mesh({1, 2, 3}),
                           make_sphere_mesh(2, 500),
                           make_gear_mesh(9, 1, 1.4, 0.5, 0.3),
                           make_torus_knot_mesh(2, 3, 2, 0.8, 0.3, 900),
                           both(make_box_mesh({1, 1, 1}), make_box_mesh({1, 1, 1}), {2, 2, 0}),  // meet in an edge
                           both(make_box_mesh({1, 1, 1}), make_box_mesh({1, 1, 1}), {2, 2, 2})}; // meet in a corner
    for (const Mesh& mesh : meshes)
        for (std::uint64_t seed = 0; seed < 6; ++seed)
            for (const Mesh& broken :
                 {loosened(mesh, distance / 2, seed), with_corners_on_edges(mesh, distance, seed),
                  with_some_turned(mesh, seed),
                  with_some_turned(loosened(with_corners_on_edges(mesh, distance / 2, seed), distance / 2, seed),
                                   seed)}) {
                EXPECT_FALSE(is_closed(broken));
                const MendedMesh result = mended(broken, distance);
                const Mending& mending = result.mending;
                ASSERT_TRUE(mending.closed) << mending.why_open() << ", " << mending.done() << ", seed " << seed;
                EXPECT_TRUE(is_closed(result.mesh));
                EXPECT_LE(mending.moved, 3 * distance);
                EXPECT_NEAR(volume_of(result.mesh), volume_of(mesh), 1e-3 * volume_of(mesh));
                PointLocator locator;
                const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
                for (std::uint64_t k = 0; k < 30; ++k) {
                    Vector3d p;
                    for (std::uint64_t i = 0; i < 3; ++i)
                        p[int(i)] =
                            mesh.bounds.min[int(i)] + u01(seed, k, i) * (mesh.bounds.max - mesh.bounds.min)[int(i)];
                    EXPECT_EQ(locator.place(p, result.mesh, nullptr, RelativePose(here, here)),
                              locator.place(p, mesh, nullptr, RelativePose(here, here)));
                }
            }
}

TEST(MendedMesh, LeavesClosedAndOpenMeshesAsTheyAre)
{
    const auto unchanged = [](const Mesh& mesh) {
        const MendedMesh result = mended(mesh, distance);
        EXPECT_EQ(result.mesh.vertices, mesh.vertices);
        EXPECT_EQ(result.mesh.triangles, mesh.triangles);
        EXPECT_FALSE(result.mending.changed());
        EXPECT_EQ(result.mending.done(), "");
        return result.mending;
    };
    EXPECT_TRUE(unchanged(make_sphere_mesh(1, 200)).closed);
    Mesh inner = make_box_mesh({.5, .5, .5});
    for (Triangle& t : inner.triangles) std::swap(t[0], t[1]);
    EXPECT_TRUE(unchanged(both(make_box_mesh({1, 1, 1}), inner)).closed) << "a hollow box";

    Mesh hole = make_box_mesh({1, 1, 1});
    hole.triangles.pop_back();
    const Mending open = unchanged(hole);
    EXPECT_FALSE(open.closed);
    EXPECT_EQ(open.open_edges, 3u);
    EXPECT_NEAR(open.open_length, 4 + std::sqrt(8), 1e-12);
    EXPECT_EQ(open.why_open(), "3 open edges");
    EXPECT_FALSE(unchanged(with_corners_on_edges(make_box_mesh({1, 1, 1}), 4 * distance, 3)).closed) << "too far away";
    EXPECT_FALSE(unchanged(loosened(make_box_mesh({1, 1, 1}), 4 * distance, 3)).closed);
    // The projective plane has one side.
    const Mesh one_sided = make_mesh(
        "p", {{0, 0, 1}, {1, 0, 0}, {.3, 1, 0}, {-.8, .6, 0}, {-.8, -.6, .2}, {.3, -1, 0}},
        {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 1}, {1, 2, 4}, {2, 3, 5}, {3, 4, 1}, {4, 5, 2}, {5, 1, 3}});
    EXPECT_EQ(unchanged(one_sided).why_open(), "it has one side");
    const Mesh soup = make_soup_mesh(2000, 0.3, 1, 5);
    EXPECT_FALSE(unchanged(soup).closed);
}

TEST(MendedMesh, ACavityOfAMeshThatIsTurnedStaysSolid)
{
    // Which way a cavity faces is lost; taking it for solid loses no collision.
    Mesh inner = make_box_mesh({.5, .5, .5});
    for (Triangle& t : inner.triangles) std::swap(t[0], t[1]);
    const Mesh hollow = both(make_box_mesh({1, 1, 1}), inner);
    Mesh turned = hollow;
    for (std::size_t t = 12; t < 24; t += 2) std::swap(turned.triangles[t][0], turned.triangles[t][1]);
    const MendedMesh result = mended(turned, distance);
    ASSERT_TRUE(result.mending.closed);
    EXPECT_EQ(result.mending.turned, 6u);
    EXPECT_NEAR(volume_of(result.mesh), 9, 1e-12);
    Mesh outer = hollow; // the cavity itself was not touched
    std::swap(outer.triangles[0][0], outer.triangles[0][1]);
    EXPECT_NEAR(volume_of(mended(outer, distance).mesh), 7, 1e-12);
}

} // namespace
} // namespace oncollide::tools
