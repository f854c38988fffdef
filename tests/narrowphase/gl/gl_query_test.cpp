// The paper's occlusion queries: they are not conservative, so misses are counted and not forbidden.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include <oncollide/narrowphase/gl/gpu.hpp>

#include "narrowphase/geometry_surface.hpp"
#include "narrowphase/octant_truth.hpp"

namespace oncollide::gl_query_test {
namespace {

using Primitives = GlQueryOptions::Primitives;
using Samples = GlQueryOptions::Samples;
using Draw = GlQueryOptions::Draw;

/// Results of a whole tree compared with the truth. The truth determines which cells are tested, so that a miss hides
/// no other.
struct Score {
    int grey = 0;   ///< octants that the surface enters
    int missed = 0; ///< of the grey octants
    int far = 0;    ///< reported grey, though the surface is farther than the backend's tolerance
};

Score score(OcclusionBackend& backend, const Mesh& mesh, int depth)
{
    Score score;
    grow(backend, mesh, depth, [&](const RootCell& root, CellKey cell, unsigned grey) {
        const unsigned truth = octants_entered(mesh, root, cell, 0);
        score.grey += std::popcount(truth);
        score.missed += std::popcount(truth & ~grey);
        const double octant = std::ldexp(root.scale, -level_of(cell) - 1);
        if (grey & ~truth)
            score.far +=
                std::popcount(grey & ~octants_entered(mesh, root, cell, root.test_error() + backend.error(octant)));
        return truth;
    });
    return score;
}

Score score(const GlQueryOptions& options, const Mesh& mesh, int depth)
{
    return score(*make_gl_query_backend(options), mesh, depth);
}

Mesh knot(int triangles)
{
    return make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, triangles);
}

std::vector<unsigned> masks_of(OcclusionBackend& backend, const Mesh& mesh, int depth)
{
    std::vector<unsigned> masks;
    grow(backend, mesh, depth, [&](auto&&, CellKey, unsigned grey) {
        masks.push_back(grey);
        return grey;
    });
    return masks;
}

TEST(GlQuery, GivesTheSameAnswersHoweverTheMeshIsDrawn)
{
    // In the soup, triangles end within half a texel of octants: inherited lists must cover the whole inflated view.
    for (const Mesh& mesh : {knot(1000), make_soup_mesh(300, 0.7, 3, 10)})
        for (const bool inflated : {false, true}) {
            std::vector<unsigned> first;
            for (const Primitives primitives : {Primitives::soup, Primitives::indexed, Primitives::strips})
                for (const Samples samples : {Samples::passed, Samples::any})
                    for (const Draw draw : {Draw::mesh, Draw::inherited}) {
                        const auto backend = make_gl_query_backend(
                            {.primitives = primitives, .samples = samples, .draw = draw, .inflated = inflated});
                        const std::vector<unsigned> masks = masks_of(*backend, mesh, 3);
                        if (first.empty()) first = masks;
                        EXPECT_EQ(masks, first) << backend->name();
                    }
        }
}

TEST(GlQuery, NamesItsOptionsAndItsRenderer)
{
    const auto backend = make_gl_query_backend({.viewport = 32, .samples = Samples::passed, .inflated = true});
    EXPECT_EQ(backend->name(), "gl-query (32 px, indexed, passed, inherited, inflated)");
    EXPECT_EQ(make_gl_query_backend({.primitives = Primitives::strips})->name(), "gl-query (16 px, strips, any, mesh)");
    EXPECT_EQ(backend->renderer(), describe_gpu(-1).renderer);
}

TEST(GlQuery, KeepsNoOctantFarFromTheSurface)
{
    for (const Case& c : cases())
        for (const bool inflated : {false, true})
            EXPECT_EQ(score({.viewport = 8, .inflated = inflated}, c.mesh, 3).far, 0) << c.name << inflated;
}

TEST(GlQuery, MissesTrianglesThatNoPixelSees)
{
    const auto cpu = make_cpu_backend();
    for (const Case& c : cases()) {
        if (!c.name.ends_with("needles") && c.name != "tiny triangles") continue;
        const Score seen = score({}, c.mesh, 3);
        EXPECT_GT(seen.missed, seen.grey / 2) << c.name;
        EXPECT_EQ(score(*cpu, c.mesh, 3).missed, 0) << c.name;
    }
}

TEST(GlQuery, MissesFewOctantsOfOrdinaryMeshesAndFewerWhenInflated)
{
    for (const auto& [name, mesh] : cases()) {
        if (name != "knot" && name != "terrain" && name != "soup") continue;
        const Score plain = score({}, mesh, 4), inflated = score({.inflated = true}, mesh, 4);
        EXPECT_GT(plain.missed, 0) << name << ": a surface that only enters by an edge or a corner";
        EXPECT_LT(plain.missed, plain.grey / 20) << name;
        EXPECT_LT(inflated.missed, plain.missed / 4) << name;
    }
}

/// A square perpendicular to `axis` on either side of the centre, and invisible specks that make the root a cube.
Mesh squares_facing(int axis)
{
    std::vector<Eigen::Vector3d> v;
    std::vector<Triangle> t;
    const auto add = [&](std::initializer_list<Eigen::Vector3d> points, std::initializer_list<Triangle> triangles) {
        const auto first = static_cast<std::uint32_t>(v.size());
        for (const Eigen::Vector3d& p : points) v.emplace_back(p[(3 - axis) % 3], p[(4 - axis) % 3], p[(5 - axis) % 3]);
        for (const Triangle& n : triangles) t.push_back({first + n[0], first + n[1], first + n[2]});
    };
    for (const double x : {-0.4, 0.4}) add({{x, -1, -1}, {x, 1, -1}, {x, 1, 1}, {x, -1, 1}}, {{0, 1, 2}, {0, 2, 3}});
    for (const double x : {-1.0, 1.0}) add({{x, x, x}, {x * 0.999, x, x}, {x, x * 0.999, x}}, {{0, 1, 2}});
    return make_mesh("squares", v, t);
}

/// The result for the root and the number of queries that it took.
std::pair<unsigned, std::uint64_t> ask_root(OcclusionBackend& backend, const Geometry& geometry)
{
    backend.attach(0, make_surface(geometry, root_cell_of(geometry)));
    std::vector<OctantResult> answer(1);
    const BatchWork work = backend.run(std::vector<OctantRow>{{0, root_cell, all_triangles, false}}, 1, answer);
    return {answer[0].grey, work.queries};
}

TEST(GlQuery, LooksAlongEachAxisInTurnAndStopsAtTheFirstFragment)
{
    const auto backend = make_gl_query_backend();
    for (const int axis : {0, 1, 2}) {
        const auto [grey, queries] = ask_root(*backend, {"squares", squares_facing(axis), {}});
        EXPECT_EQ(grey, 0xffu) << axis;
        EXPECT_EQ(queries, 8u * (axis + 1));
    }
}

TEST(GlQuery, AsksThreeTimesInVainWhereNoSurfaceIs)
{
    const Geometry geometry{"knot", knot(600), {}};
    for (const Draw draw : {Draw::mesh, Draw::inherited}) {
        const auto backend = make_gl_query_backend({.draw = draw});
        backend->attach(0, make_surface(geometry, root_cell_of(geometry)));
        CellKey middle = root_cell;
        for (unsigned octant : {0u, 7u, 7u, 7u}) middle = child_cell(middle, octant);
        std::vector<OctantResult> answer(1);
        const BatchWork work = backend->run(std::vector<OctantRow>{{0, middle, all_triangles, true}}, 1, answer);
        EXPECT_EQ(answer[0].grey, 0);
        EXPECT_EQ(work.queries, 24u);
    }
}

TEST(GlQuery, AsksAsOftenAsThePaperSays)
{
    const auto backend = make_gl_query_backend();
    for (const auto& [name, mesh] :
         {Case{"knot", knot(1500)}, Case{"gear", make_gear_mesh(12, 1, 1.3, 0.4, 0.3)},
          Case{"terrain", make_terrain_mesh(10, 2, 16, 3)}, Case{"sphere", make_sphere_mesh(1, 1000)},
          Case{"torus", make_torus_mesh(1, 0.3, 1000)}, Case{"soup", make_soup_mesh(300, 0.7, 3, 10)}}) {
        const std::uint64_t root_queries = ask_root(*backend, {"mesh", mesh, {}}).second;
        EXPECT_GE(root_queries, 8u) << name;
        EXPECT_LE(root_queries, 16u) << name << ": Table 1 of the paper has 9 to 13";
    }
}

TEST(GlQuery, AnswersABatchOfMoreQueriesThanAreInFlightLikeItsRows)
{
    const auto backend = make_gl_query_backend();
    const Mesh mesh = knot(600);
    std::vector<OctantRow> rows;
    const Ocst tree = grow(*backend, mesh, 3, [](auto&&, CellKey, unsigned grey) { return grey; });
    for (CellKey cell = 1 << 6; cell < 1 << 7; ++cell)
        if (tree.knows(cell)) rows.push_back({0, cell, tree.parent_list(cell), false});
    const std::size_t cells = rows.size();
    while (rows.size() < 1200) rows.push_back(rows[rows.size() - cells]);

    std::vector<OctantResult> answers(rows.size()), one(1);
    const BatchWork work = backend->run(rows, 2, answers);
    EXPECT_GT(work.queries, 2 * 4096u);
    EXPECT_LE(work.queries, 24 * rows.size());
    EXPECT_GT(work.bytes, 0u);
    EXPECT_GT(work.wait_ms, 0);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        if (i < cells) backend->run(std::span(rows).subspan(i, 1), 1, one);
        EXPECT_EQ(answers[i].grey, i < cells ? one[0].grey : answers[i - cells].grey) << i;
    }
}

TEST(GlQuery, ListsEveryTriangleThatEntersAnOctant)
{
    const Mesh mesh = knot(600);
    for (const Draw draw : {Draw::mesh, Draw::inherited}) {
        const auto backend = make_gl_query_backend({.draw = draw});
        std::vector<CellKey> cells;
        RootCell root;
        const Ocst tree = grow(*backend, mesh, 4, [&](const RootCell& r, CellKey cell, unsigned grey) {
            root = r;
            if (cell != root_cell) cells.push_back(cell);
            return grey;
        });
        for (const CellKey cell : cells) {
            std::vector<std::uint32_t> listed;
            std::vector<std::size_t> ends;
            backend->read(std::vector<ListRead>{{0, tree.parent_list(cell), octant_of(cell)}}, listed, ends);
            EXPECT_TRUE(std::is_sorted(listed.begin(), listed.end()));
            for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
                EXPECT_LE(enters(mesh, mesh.triangles[t], root, cell, 0),
                          std::binary_search(listed.begin(), listed.end(), t))
                    << t << " in cell " << cell;
        }
        const std::size_t bytes = backend->bytes();
        backend->detach(0);
        EXPECT_LT(backend->bytes(), bytes);
        EXPECT_FALSE(backend->attached(0));
    }
}

TEST(GlQuery, FillsTheInsideOfSolidShapes)
{
    const Geometry ball{"ball", Shape{Sphere{1}}, {}};
    const RootCell root = root_cell_of(ball);
    const auto backend = make_gl_query_backend();
    backend->attach(0, make_surface(ball, root));
    CellKey inner = root_cell;
    for (unsigned octant : {0u, 7u, 7u}) inner = child_cell(inner, octant); // next to the centre
    std::vector<OctantResult> answer(1);
    const BatchWork work = backend->run(std::vector<OctantRow>{{0, inner, all_triangles, false}}, 1, answer);
    EXPECT_EQ(answer[0].grey, 0xff);
    EXPECT_EQ(work.queries, 0u) << "no query is left";
}

TEST(GlQuery, AnswersMapsAsTheCpuDoes)
{
    std::vector<MapCell> cells;
    for (const int at : {-9, -2, 3, 8}) cells.push_back({at, at, at, 1});
    const Geometry geometry{"map", make_occupancy_map("map", 0.1, cells), {}};
    const auto queries = make_gl_query_backend(), cpu = make_cpu_backend();
    EXPECT_EQ(ask_root(*queries, geometry), ask_root(*cpu, geometry));
}

TEST(GlQuery, RefusesOptionsThatMakeNoSense)
{
    const auto message = [](const GlQueryOptions& options) -> std::string {
        try {
            make_gl_query_backend(options);
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::usage);
            return error.what();
        }
        return "accepted";
    };
    for (const int viewport : {-5, 0, 1025, 1 << 30})
        EXPECT_NE(message({.viewport = viewport}).find("viewport is " + std::to_string(viewport)), std::string::npos);
    EXPECT_NE(message({.primitives = Primitives(3)}).find("primitives"), std::string::npos);
    EXPECT_NE(message({.samples = Samples(2)}).find("samples"), std::string::npos);
    EXPECT_NE(message({.draw = Draw(9)}).find("draw"), std::string::npos);
    for (const int viewport : {1, 1024}) EXPECT_NO_THROW(make_gl_query_backend({.viewport = viewport}));
}

} // namespace
} // namespace oncollide::gl_query_test
