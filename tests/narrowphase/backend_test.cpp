#include <gtest/gtest.h>

#include <oncollide/narrowphase/ocst.hpp>
#include <oncollide/scenes/mesh_generators.hpp>

namespace oncollide {
namespace {

using Polygon = std::vector<Eigen::Vector3d>;

/// The part of a polygon on the side n . x <= d (Sutherland and Hodgman).
Polygon clip(const Polygon& in, int axis, double sign, double d)
{
    Polygon out;
    for (std::size_t i = 0; i < in.size(); ++i) {
        const Eigen::Vector3d &p = in[i], &q = in[(i + 1) % in.size()];
        const double sp = sign * p[axis] - d, sq = sign * q[axis] - d;
        if (sp <= 0) out.push_back(p);
        if ((sp < 0 && sq > 0) || (sp > 0 && sq < 0)) out.push_back(p + (q - p) * (sp / (sp - sq)));
    }
    return out;
}

/// Does the triangle enter the box grown by `grow`? By clipping in double, independent of the test's separating axes.
bool enters(const Mesh& mesh, const Triangle& t, const Eigen::Vector3d& centre, const Eigen::Vector3d& half,
            double grow)
{
    Polygon polygon{mesh.vertices[t[0]] - centre, mesh.vertices[t[1]] - centre, mesh.vertices[t[2]] - centre};
    for (int axis = 0; axis < 3 && !polygon.empty(); ++axis)
        for (double sign : {1.0, -1.0}) polygon = clip(polygon, axis, sign, half[axis] + grow);
    return !polygon.empty();
}

struct Case {
    std::string name;
    Mesh mesh;
};

Mesh moved(Mesh mesh, double scale, const Eigen::Vector3d& by)
{
    return transformed("moved", std::move(mesh), scale, -by / scale);
}

std::vector<Case> cases()
{
    std::vector<Case> all;
    all.push_back({"knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 1500)});
    all.push_back({"gear", make_gear_mesh(12, 1, 1.3, 0.4, 0.3)});
    all.push_back({"terrain", make_terrain_mesh(10, 2, 16, 3)});
    all.push_back({"needles", make_needles_mesh(300, 1, 1e5, 3, 7)});
    all.push_back({"thin needles", make_needles_mesh(300, 1, 1e12, 3, 8)});
    all.push_back({"tiny triangles", make_soup_mesh(400, 1e-5, 3, 9)});
    all.push_back({"soup", make_soup_mesh(300, 0.7, 3, 10)});
    all.push_back({"box: axis-aligned faces on cell faces", make_box_mesh({1, 1, 1})});
    all.push_back(
        {"flat", make_mesh("flat", {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {{0, 1, 2}, {0, 2, 3}})});
    all.push_back({"one zero-area triangle", make_mesh("line", {{0, 0, 0}, {1, 2, 3}, {2, 4, 6}}, {{0, 1, 2}})});
    all.push_back({"knot at 1e6", moved(make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 800), 1, {1e6, -1e6, 1e6})});
    all.push_back({"soup of size 1e-6", moved(make_soup_mesh(200, 0.5, 3, 11), 1e-6, {0, 0, 0})});
    all.push_back({"soup of size 1e6", moved(make_soup_mesh(200, 0.5, 3, 12), 1e6, {0, 0, 0})});
    return all;
}

class EveryBackend : public ::testing::TestWithParam<std::unique_ptr<OcclusionBackend> (*)()> {
protected:
    std::unique_ptr<OcclusionBackend> backend_ = GetParam()();

    /// Grows the whole tree to `depth`, giving each answered cell to `check`.
    template <class Check>
    Ocst grow(const Mesh& mesh, int depth, Check check)
    {
        const Geometry geometry{"mesh", mesh, {}};
        const RootCell root = root_cell_of(geometry);
        Ocst tree(root, depth, 0);
        backend_->attach(0, make_surface(geometry, root));
        std::vector<CellKey> level{root_cell};
        while (!level.empty()) {
            std::vector<OctantRow> rows;
            for (CellKey cell : level) rows.push_back(tree.row(0, cell));
            std::vector<OctantAnswer> answers(rows.size());
            backend_->ask(rows, 2, answers);
            std::vector<CellKey> next;
            for (std::size_t i = 0; i < rows.size(); ++i) {
                tree.expand(level[i], answers[i], 1);
                check(root, level[i], answers[i].grey);
                for (unsigned k = 0; k < 8; ++k)
                    if (answers[i].grey >> k & 1 && level_of(level[i]) + 1 < depth)
                        next.push_back(child_cell(level[i], k));
            }
            level = next;
        }
        return tree;
    }
};

TEST_P(EveryBackend, NeverClearsAnOctantThatTheSurfaceEntersNorKeepsOneFarFromIt)
{
    for (const Case& c : cases()) {
        std::size_t lost = 0, far = 0, cells = 0;
        grow(c.mesh, 4, [&](const RootCell& root, CellKey cell, unsigned grey) {
            ++cells;
            for (unsigned k = 0; k < 8; ++k) {
                const CellKey octant = child_cell(cell, k);
                const auto at = centre_of(octant);
                Eigen::Vector3d centre, half;
                for (int axis = 0; axis < 3; ++axis) {
                    half[axis] = std::ldexp(double(root.half[axis]), -level_of(octant));
                    centre[axis] = root.centre[axis] + at[axis] * half[axis];
                }
                bool inside = false, near = false;
                for (const Triangle& t : c.mesh.triangles) {
                    inside = inside || enters(c.mesh, t, centre, half, 0);
                    near = near || enters(c.mesh, t, centre, half, root.false_reach());
                }
                lost += inside && !(grey >> k & 1);
                far += !near && (grey >> k & 1);
            }
        });
        EXPECT_EQ(lost, 0u) << c.name;
        EXPECT_EQ(far, 0u) << c.name << " of " << cells << " cells";
    }
}

TEST_P(EveryBackend, GivesTheTrianglesOfEachOctant)
{
    const Mesh mesh = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 600);
    const Ocst tree = grow(mesh, 4, [](auto&&...) {});
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
    std::vector<OctantAnswer> answer(1);
    backend_->ask(std::vector<OctantRow>{{0, inner, all_triangles, false}}, 1, answer);
    EXPECT_EQ(answer[0].grey, 0xff);
}

INSTANTIATE_TEST_SUITE_P(, EveryBackend, ::testing::Values(&make_cpu_backend), [](const auto&) { return "cpu"; });

} // namespace
} // namespace oncollide
