// Joined faces: the same surface with fewer triangles.
#include <algorithm>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/inside/cut_polygon.hpp>
#include <oncollide/narrowphase/inside/flat_faces.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::flat_faces_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Loops = std::vector<std::vector<std::uint32_t>>;

double area(std::span<const Vector2d> points, const std::vector<std::uint32_t>& loop)
{
    double twice = 0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Vector2d &u = points[loop[i]], &v = points[loop[(i + 1) % loop.size()]];
        twice += u.x() * v.y() - u.y() * v.x();
    }
    return twice / 2;
}

/// Adds a star-shaped loop with `count` corners.
void add_star(std::vector<Vector2d>& points, Loops& loops, const Vector2d& centre, double size, int count,
              std::uint64_t seed, bool hole)
{
    auto& loop = loops.emplace_back();
    for (int i = 0; i < count; ++i) {
        const double turn = 2 * M_PI * i / count, reach = size * (0.4 + 0.6 * u01(seed, std::uint64_t(i), 0));
        loop.push_back(static_cast<std::uint32_t>(points.size()));
        points.push_back(centre + reach * Vector2d(std::cos(turn), std::sin(turn)));
    }
    if (hole) std::ranges::reverse(loop);
}

TEST(CutPolygon, CutsPolygonsWithHolesIntoTrianglesOfTheSameArea)
{
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        std::vector<Vector2d> points;
        Loops loops;
        const int count = 3 + int(seed % 30);
        add_star(points, loops, {0, 0}, 1, count, seed, false);
        std::size_t corners = loops[0].size();
        if (count > 8)
            for (int h = 0; h < int(seed % 4); ++h) {
                const double turn = 2 * M_PI * h / 3;
                add_star(points, loops, 0.2 * Vector2d(std::cos(turn), std::sin(turn)), 0.1, 3 + h, seed + 999, true);
                corners += loops.back().size() + 2;
            }
        double wanted = 0;
        for (const auto& loop : loops) wanted += area(points, loop);
        const auto cut = cut_polygon(points, loops);
        ASSERT_TRUE(cut) << seed;
        EXPECT_EQ(cut->size(), corners - 2) << seed;
        double sum = 0;
        std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
        for (const Triangle& t : *cut) {
            EXPECT_GT(orient2d(points[t[0]], points[t[1]], points[t[2]]), 0) << seed;
            sum += area(points, {t[0], t[1], t[2]});
            for (int k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}], --sides[{t[(k + 1) % 3], t[k]}];
        }
        EXPECT_NEAR(sum, wanted, 1e-12) << seed;
        for (const auto& loop : loops)
            for (std::size_t i = 0; i < loop.size(); ++i) --sides[{loop[i], loop[(i + 1) % loop.size()]}];
        for (const auto& [side, times] : sides) EXPECT_LE(times, 0) << seed; // only the loops are left
    }
}

TEST(CutPolygon, KeepsCornersOnStraightSidesAndRefusesWhatIsNoPolygon)
{
    // A square with corners in the middle of its sides: eight corners, six triangles.
    const std::vector<Vector2d> square = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
    const auto cut = cut_polygon(square, {{0, 1, 2, 3, 4, 5, 6, 7}});
    ASSERT_TRUE(cut);
    EXPECT_EQ(cut->size(), 6u);
    EXPECT_FALSE(cut_polygon(square, {{7, 6, 5, 4, 3, 2, 1, 0}})); // clockwise
    EXPECT_FALSE(cut_polygon(square, {{0, 4, 2, 6}}));             // crosses itself
}

/// Each triangle is cut into `cells`^2 parts: the faces stay flat.
Mesh refined(const Mesh& mesh, int cells)
{
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (const Triangle& t : mesh.triangles) {
        const Vector3d a = mesh.vertices[t[0]], u = (mesh.vertices[t[1]] - a) / cells,
                       v = (mesh.vertices[t[2]] - a) / cells;
        const auto at = [&](int i, int k) {
            vertices.push_back(a + double(i) * u + double(k) * v);
            return static_cast<std::uint32_t>(vertices.size() - 1);
        };
        for (int i = 0; i < cells; ++i)
            for (int k = 0; i + k < cells; ++k) {
                triangles.push_back({at(i, k), at(i + 1, k), at(i, k + 1)});
                if (i + k + 1 < cells) triangles.push_back({at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)});
            }
    }
    return make_mesh("refined", std::move(vertices), std::move(triangles));
}

TEST(FlatFaces, ABoxOfManyTrianglesHasTwelveAgain)
{
    const Mesh fine = refined(make_box_mesh({1, 0.5, 0.25}), 8);
    ASSERT_EQ(fine.triangles.size(), 768u);
    const MeshLinks links = links_of(fine);
    ASSERT_TRUE(links.closed);
    const auto flat = join_flat_faces(fine, links);
    ASSERT_TRUE(flat);
    EXPECT_EQ(flat->mesh.triangles.size(), 12u);
    EXPECT_EQ(flat->mesh.vertices.size(), 8u);
    EXPECT_TRUE(links_of(flat->mesh).closed);
    EXPECT_FALSE(links_of(flat->mesh).reversed);
    for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(flat->mesh.vertices[i], fine.vertices[flat->vertex[i]]);
    EXPECT_FALSE(join_flat_faces(make_box_mesh({1, 1, 1}), links_of(make_box_mesh({1, 1, 1})))); // nothing to save
}

/// A square plate with a square hole through it.
Mesh plate()
{
    const std::vector<Vector2d> flat = {{-4, -4}, {4, -4}, {4, 4}, {-4, 4}, {-1, -1}, {-1, 1}, {1, 1}, {1, -1}};
    std::vector<Vector3d> vertices;
    for (const double z : {-1.0, 1.0})
        for (const Vector2d& p : flat) vertices.emplace_back(p.x(), p.y(), z);
    std::vector<Triangle> triangles;
    const auto cut = cut_polygon(flat, {{0, 1, 2, 3}, {4, 5, 6, 7}});
    for (const auto& [a, b, c] : *cut) triangles.push_back({a, c, b}), triangles.push_back({a + 8, b + 8, c + 8});
    for (const std::uint32_t loop : {0u, 4u})
        for (std::uint32_t k = 0; k < 4; ++k) {
            const std::uint32_t u = loop + k, v = loop + (k + 1) % 4;
            triangles.push_back({u, v, v + 8}), triangles.push_back({u, v + 8, u + 8});
        }
    return make_mesh("plate", std::move(vertices), std::move(triangles));
}

TEST(FlatFaces, APlateKeepsItsHoleItsVolumeAndItsFaces)
{
    const Mesh coarse = plate();
    ASSERT_EQ(coarse.triangles.size(), 32u);
    const Mesh fine = refined(coarse, 4);
    const MeshLinks links = links_of(fine);
    ASSERT_TRUE(links.closed);
    const auto flat = join_flat_faces(fine, links);
    ASSERT_TRUE(flat);
    EXPECT_EQ(flat->mesh.triangles.size(), coarse.triangles.size());
    EXPECT_EQ(flat->mesh.vertices.size(), coarse.vertices.size());
    EXPECT_TRUE(links_of(flat->mesh).closed);
    const auto volume = [](const Mesh& mesh) {
        double six = 0;
        for (const auto& [a, b, c] : mesh.triangles)
            six += mesh.vertices[a].dot(mesh.vertices[b].cross(mesh.vertices[c]));
        return six / 6;
    };
    EXPECT_NEAR(volume(flat->mesh), volume(fine), 1e-12);
    for (std::size_t t = 0; t < flat->mesh.triangles.size(); ++t) { // in the plane of the face that it names
        const Triangle& first = fine.triangles[flat->face[t]];
        for (const std::uint32_t v : flat->mesh.triangles[t])
            EXPECT_EQ(orient3d(fine.vertices[first[0]], fine.vertices[first[1]], fine.vertices[first[2]],
                               flat->mesh.vertices[v]),
                      0);
    }
}

TEST(FlatFaces, AMeshWithAHoleKeepsTheHole)
{
    Mesh open = refined(make_box_mesh({1, 1, 1}), 4);
    open.triangles.pop_back();
    const Mesh holed = make_mesh("holed", open.vertices, open.triangles);
    const MeshLinks links = links_of(holed);
    ASSERT_FALSE(links.closed);
    const auto flat = join_flat_faces(holed, links);
    ASSERT_TRUE(flat);
    double area = 0, wanted = 0;
    for (const auto& [mesh, sum] : {std::pair(&flat->mesh, &area), std::pair(&holed, &wanted)})
        for (const auto& [a, b, c] : mesh->triangles)
            *sum += (mesh->vertices[b] - mesh->vertices[a]).cross(mesh->vertices[c] - mesh->vertices[a]).norm() / 2;
    EXPECT_NEAR(area, wanted, 1e-12);
    EXPECT_LT(area, 24);
}

} // namespace
} // namespace oncollide::flat_faces_test
