#include <gtest/gtest.h>

#include <oncollide/narrowphase/gl/gpu.hpp>

#include <algorithm>
#include <bit>

#include "narrowphase/geometry_surface.hpp"
#include "narrowphase/octant_truth.hpp"

namespace oncollide {
namespace {

std::unique_ptr<OcclusionBackend> make_default_gl_compute()
{
    return make_gl_compute_backend();
}

class EveryBackend : public ::testing::TestWithParam<std::unique_ptr<OcclusionBackend> (*)()> {
protected:
    std::unique_ptr<OcclusionBackend> backend_ = GetParam()();
};

TEST_P(EveryBackend, NeverClearsAnOctantThatTheSurfaceEntersNorKeepsOneFarFromIt)
{
    for (const Case& c : cases()) {
        int lost = 0, far = 0, cells = 0;
        grow(*backend_, c.mesh, 4, [&](const RootCell& root, CellKey cell, unsigned grey) {
            ++cells;
            lost += std::popcount(octants_entered(c.mesh, root, cell, 0) & ~grey);
            far += std::popcount(grey & ~octants_entered(c.mesh, root, cell, root.test_error()));
            return grey;
        });
        EXPECT_EQ(lost, 0) << c.name;
        EXPECT_EQ(far, 0) << c.name << " of " << cells << " cells";
    }
}

TEST_P(EveryBackend, GivesTheTrianglesOfEachOctant)
{
    const Mesh mesh = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 600);
    const Ocst tree = grow(*backend_, mesh, 4, [](auto&&, CellKey, unsigned grey) { return grey; });
    std::vector<std::uint32_t> seen;
    std::size_t cells = 0;
    for (CellKey a = 0; a < 8; ++a)
        for (CellKey b = 0; b < 8; ++b) {
            const CellKey cell = (root_cell << 3 | a) << 3 | b;
            if (!tree.knows(cell)) continue;
            std::vector<std::uint32_t> triangles;
            std::vector<std::size_t> ends;
            backend_->read(std::vector<ListRead>{{0, tree.parent_list(cell), octant_of(cell)}}, triangles, ends);
            EXPECT_FALSE(triangles.empty()) << "a grey cell has triangles";
            EXPECT_TRUE(std::is_sorted(triangles.begin(), triangles.end()));
            seen.insert(seen.end(), triangles.begin(), triangles.end());
            ++cells;
        }
    EXPECT_GT(cells, 8u);
    std::sort(seen.begin(), seen.end());
    seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
    EXPECT_EQ(seen.size(), mesh.triangles.size()) << "every triangle is in some cell";
}

TEST_P(EveryBackend, FillsTheInsideOfSolidShapes)
{
    const Geometry ball{"ball", Shape{Sphere{1}}, {}};
    const RootCell root = root_cell_of(ball);
    backend_->attach(0, make_surface(ball, root));
    CellKey inner = root_cell;
    for (unsigned octant : {0u, 7u, 7u}) inner = child_cell(inner, octant); // next to the centre
    std::vector<OctantResult> answer(1);
    backend_->run(std::vector<OctantRow>{{0, inner, all_triangles, false}}, 1, answer);
    EXPECT_EQ(answer[0].grey, 0xff);
}

INSTANTIATE_TEST_SUITE_P(, EveryBackend, ::testing::Values(&make_cpu_backend, &make_default_gl_compute),
                         [](const auto& made) { return made.index ? "gl_compute" : "cpu"; });

} // namespace
} // namespace oncollide
