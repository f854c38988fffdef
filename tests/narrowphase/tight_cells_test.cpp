#include <algorithm>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include <oncollide/narrowphase/listed_surfaces.hpp>
#include <oncollide/narrowphase/occlusion_backend.hpp>
#include <oncollide/narrowphase/tight_cells.hpp>
#include <oncollide/scenes/mesh_generators.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;

/// How far a point of the surface, relative to the root's centre, is outside what an octant's bounds say; and what part
/// of the plain sphere's volume the bounds leave.
struct Bounds {
    Vector3d centre, normal;
    double radius, half;

    Bounds(const RootCell& root, const TightBlock& block, CellKey child)
    {
        const unsigned k = octant_of(child);
        const auto place = centre_of(child);
        const double size = std::ldexp(1.0, -level_of(child));
        const int moved[3] = {block.x[k], block.y[k], block.z[k]};
        for (int axis = 0; axis < 3; ++axis)
            centre[axis] = (place[std::size_t(axis)] + moved[axis] / 127.0) * size * root.half[std::size_t(axis)];
        normal = Vector3d(block.nx[k], block.ny[k], block.nz[k]).normalized();
        radius = root.radius * size * block.r[k] / 255, half = root.radius * size * block.h[k] / 255;
    }
    double outside(const Vector3d& p) const
    {
        return std::max((p - centre).norm() - radius, std::abs(normal.dot(p - centre)) - half);
    }
};

class TightCells : public ::testing::Test {
protected:
    /// Grows a whole tree to `depth` and holds points of the mesh against the bounds of every cell that they are in.
    void check(const Mesh& mesh, int depth)
    {
        const Geometry geometry{"mesh", mesh, {}};
        const RootCell root = root_cell_of(geometry);
        const auto backend = make_cpu_backend();
        backend->attach(0, make_surface(geometry, root));
        std::vector<Vector3d> points;
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
            for (std::uint64_t k = 0; k < 12; ++k) {
                double u = k < 3 ? double(k == 1) : u01(t, k, 0), v = k < 3 ? double(k == 2) : u01(t, k, 1);
                if (u + v > 1) u = 1 - u, v = 1 - v;
                const auto& [a, b, c] = mesh.triangles[t];
                points.push_back((1 - u - v) * mesh.vertices[a] + u * mesh.vertices[b] + v * mesh.vertices[c] -
                                 root.centre);
            }
        ASSERT_FALSE(points.empty());
        descend(*backend, root, {0, root_cell, all_triangles, true, true}, points, depth);
    }

    void descend(OcclusionBackend& backend, const RootCell& root, const OctantRow& row,
                 const std::vector<Vector3d>& points, int left)
    {
        if (left == 0 || points.empty()) return;
        OctantAnswer answer;
        backend.ask({&row, 1}, 1, {&answer, 1});
        for (unsigned k = 0; k < 8; ++k) {
            const CellKey child = child_cell(row.cell, k);
            const auto place = centre_of(child);
            const double size = std::ldexp(1.0, -level_of(child));
            std::vector<Vector3d> inside;
            for (const Vector3d& p : points) {
                bool in = true;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    in &= std::abs(p[int(axis)] - place[axis] * size * root.half[axis]) <= size * root.half[axis];
                if (in) inside.push_back(p);
            }
            if (!(answer.grey >> k & 1)) continue;
            const Bounds bounds(root, answer.tight, child);
            EXPECT_LE(bounds.radius, root.radius * size * (1 + 1e-12));
            for (const Vector3d& p : inside) worst_ = std::max(worst_, bounds.outside(p) / root.radius);
            ++cells_;
            radii_ += bounds.radius / (root.radius * size), halves_ += bounds.half / (root.radius * size);
            descend(backend, root, {0, child, answer.list, true, true}, inside, left - 1);
        }
    }

    double worst_ = -1, radii_ = 0, halves_ = 0;
    int cells_ = 0;
};

TEST_F(TightCells, HoldTheSurfaceOfTheirOctants)
{
    check(make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 3000), 7);
    EXPECT_LE(worst_, 0);
    EXPECT_GT(cells_, 5000);
    worst_ = -1, radii_ = halves_ = cells_ = 0;
    check(make_sphere_mesh(1, 20000), 5);
    EXPECT_LE(worst_, 0);
    EXPECT_LT(radii_ / cells_, 0.93) << "tighter than the plain spheres";
    EXPECT_LT(halves_ / cells_, 0.25) << "discs, where the surface is smooth";
}

TEST_F(TightCells, HoldLargeAndThinTriangles)
{
    // Three that cross the whole room, needles, points; then far from the origin.
    std::vector<Vector3d> points = {{-5, -5, -5}, {5, 5, 4},    {5, -4, 5}, {-5, 5, 5},
                                    {0, 0, 0},    {1e-7, 0, 0}, {4, 3, 2},  {4, 3, 2.0000001}};
    const std::vector<Triangle> triangles = {{0, 1, 2}, {0, 2, 3}, {1, 3, 0}, {4, 5, 6},
                                             {4, 6, 7}, {4, 4, 4}, {6, 6, 0}};
    check(make_mesh("large and thin", points, triangles), 7);
    EXPECT_LE(worst_, 0);
    EXPECT_LT(halves_ / cells_, 0.6);
    for (Vector3d& p : points) p = 1e-3 * p + Vector3d(1e6, -1e6, 1e5);
    worst_ = -1;
    check(make_mesh("far", points, triangles), 5);
    EXPECT_LE(worst_, 0);
}

/// Of all the octants of the root.
TightBlock bounds_of_root(const Mesh& mesh)
{
    const Geometry geometry{"mesh", mesh, {}};
    const auto backend = make_cpu_backend();
    backend->attach(0, make_surface(geometry, root_cell_of(geometry)));
    const OctantRow row{0, root_cell, all_triangles, true, true};
    OctantAnswer answer;
    backend->ask({&row, 1}, 1, {&answer, 1});
    return answer.tight;
}

/// Faces at right angles in one octant: which of them comes first must not choose the slab.
TEST(TightCell, DoesNotDependOnTheOrderOfTheTriangles)
{
    for (Mesh mesh :
         {make_box_mesh({0.5, 0.5, 0.5}), make_gear_mesh(9, 0.8, 1, 0.3, 0.3), make_soup_mesh(80, 0.4, 1, 9)}) {
        const TightBlock bounds = bounds_of_root(mesh);
        for (std::size_t turn = 1; turn < mesh.triangles.size(); ++turn) {
            std::rotate(mesh.triangles.begin(), mesh.triangles.begin() + 1, mesh.triangles.end());
            const TightBlock again = bounds_of_root(mesh);
            EXPECT_EQ(std::memcmp(&again, &bounds, sizeof bounds), 0) << mesh.triangles.size() << ", by " << turn;
        }
    }
}

} // namespace
} // namespace oncollide
