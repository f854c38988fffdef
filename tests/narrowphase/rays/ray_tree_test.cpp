// The tree for segments, against tests of every triangle and the walk over oriented boxes.
#include <cmath>
#include <thread>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/rays/ray_walk.hpp>
#include <oncollide/narrowphase/rays/segment_query.hpp>
#include <oncollide/narrowphase/rays/segment_tests.hpp>
#include <oncollide/pipeline/models/model_store.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::ray_tree_test {
namespace {

using Eigen::Vector3d;

Mesh moved(Mesh mesh, double scale, const Vector3d& by)
{
    for (Vector3d& v : mesh.vertices) v = scale * v + by;
    return make_mesh("moved", std::move(mesh.vertices), std::move(mesh.triangles));
}

std::vector<Mesh> meshes()
{
    Mesh flat = make_sheet_mesh(2, 6); // and triangles without area
    for (std::uint32_t k = 0; k < 40; ++k) flat.triangles.push_back({k, k + (k % 3 != 0), k + 1 + k % 2});
    flat = make_mesh("flat", std::move(flat.vertices), std::move(flat.triangles));
    const Mesh sphere = make_sphere_mesh(1, 900);
    return {sphere,
            make_torus_knot_mesh(2, 3, 1, 0.4, 0.2, 3000),
            make_soup_mesh(300, 0.7, 2, 5),
            make_needles_mesh(40, 1, 1e-6, 1, 3),
            flat,
            moved(sphere, 1e-9, Vector3d::Zero()),
            moved(sphere, 1e9, Vector3d(3e9, 1, 0)),
            moved(sphere, 1, Vector3d(1e8, -1e8, 7)),
            moved(make_box_mesh(Vector3d(1, 2, 3), 4), 1, Vector3d::Zero())};
}

/// Ordinary segments, and segments through corners, along edges and in faces, tiny ones and some from far away.
Segment draw(const Mesh& mesh, std::uint64_t seed)
{
    const auto corner = [&](std::uint64_t k) {
        const auto t = std::size_t(u01(seed, 60, k) * double(mesh.triangles.size()));
        return mesh.vertices[mesh.triangles[t][std::size_t(3 * u01(seed, 61, k))]];
    };
    const double size = 2 * mesh.bounds.half_extent().norm();
    const auto point = [&](std::uint64_t k) -> Vector3d {
        return mesh.bounds.centre() +
               size *
                   (Vector3d(u01(seed, 70 + k, 0), u01(seed, 70 + k, 1), u01(seed, 70 + k, 2)).array() - 0.5).matrix();
    };
    const Triangle& t = mesh.triangles[std::size_t(u01(seed, 62, 0) * double(mesh.triangles.size()))];
    const Vector3d middle = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
    switch (seed % 9) {
    case 0:
        return {corner(0), corner(1)};
    case 1:
        return {point(0), 2 * corner(0) - point(0)};
    case 2:
        return {mesh.vertices[t[0]] - Vector3d(0, 0, size), mesh.vertices[t[0]] + Vector3d(0, 0, size)};
    case 3:
        return {2 * mesh.vertices[t[0]] - mesh.vertices[t[1]], 2 * mesh.vertices[t[1]] - mesh.vertices[t[0]]};
    case 4:
        return {middle + 1e-6 * (point(0) - middle), middle};
    case 5:
        return {middle + 1e6 * (point(0) - middle), 2 * middle - point(0)};
    case 6:
        return {middle, middle + 0.01 * (point(0) - middle)};
    default:
        return {point(0), point(1)};
    }
}

TEST(RayTree, TakesEveryTriangleThatTheSegmentMeets)
{
    RayWalk walk;
    int met = 0, taken = 0, sure = 0;
    for (int at = 0; const Mesh& mesh : meshes()) {
        ++at;
        ObbTree boxes(mesh);
        RayTree tree(boxes);
        for (std::uint64_t seed = 0; seed < 700; ++seed) {
            const Segment segment = draw(mesh, seed);
            if (!RayWalk::covers(segment)) continue;
            std::vector<int> state(mesh.triangles.size());
            walk.walk(tree, segment, [&](std::uint32_t triangle, bool certain) {
                state[triangle] = certain ? 2 : 1;
                return 1.0;
            });
            for (std::uint32_t t = 0; t < state.size(); ++t) {
                const bool meets = triangles_meet({segment.from, segment.to, segment.to}, boxes.corners(t));
                ASSERT_TRUE(!meets || state[t]) << at << " " << seed << ": triangle " << t << " was missed";
                ASSERT_TRUE(meets || state[t] < 2) << at << " " << seed << ": triangle " << t << " is not met";
                met += meets, taken += state[t] > 0, sure += state[t] == 2;
            }
        }
        EXPECT_EQ(tree.validate(), "") << at;
    }
    EXPECT_GT(met, 4000);
    EXPECT_GT(sure, 1000);
    EXPECT_LT(taken, 2 * met);
}

TEST(RayTree, GivesTheResultsOfOrientedBoxes)
{
    SegmentQuery query;
    Settings limited;
    limited.node_budget = 1'000'000;
    int hits = 0;
    for (int at = 0; const Mesh& mesh : meshes()) {
        ++at;
        const auto geometry = std::make_shared<const Geometry>(Geometry{"", mesh, ""});
        ModelStore plain(Settings{}, make_cpu_backend()), without(limited, make_cpu_backend());
        Model &model = plain[plain.add(geometry)], &same = without[without.add(geometry)];
        plain.obb_tree(model, 0), without.obb_tree(same, 0);
        ASSERT_TRUE(model.ray_tree());
        ASSERT_FALSE(same.ray_tree());
        for (std::uint64_t seed = 0; seed < 900; ++seed) {
            const Segment segment = draw(mesh, seed);
            for (const double reach : {1.0, 0.5}) {
                const auto mine = query.first(model, segment, false, reach),
                           theirs = query.first(same, segment, false, reach);
                ASSERT_EQ(mine.has_value(), theirs.has_value()) << at << " " << seed;
                hits += mine.has_value();
                if (!mine) continue;
                EXPECT_EQ(mine->part, theirs->part) << at << " " << seed;
                EXPECT_EQ(mine->entry.lower, theirs->entry.lower) << at << " " << seed;
                EXPECT_EQ(mine->entry.upper, theirs->entry.upper) << at << " " << seed;
                EXPECT_EQ(mine->normal, theirs->normal);
            }
            EXPECT_EQ(query.meets(model, segment), query.meets(same, segment)) << at << " " << seed;
        }
    }
    EXPECT_GT(hits, 4000);
}

TEST(RayTree, IsDroppedWhenVerticesMove)
{
    Mesh mesh = make_sphere_mesh(1, 900);
    World world;
    const ModelId model = world.models().add(mesh);
    world.bodies().add({.model = model});
    const Segment up{{0.1, 0.2, 0}, {0.1, 0.2, 9}};
    const CastHit before = world.space().cast(up);
    for (Vector3d& v : mesh.vertices) v *= 3;
    world.models().set_vertices(model, 0, mesh.vertices);
    const CastHit after = world.space().cast(up);
    EXPECT_NEAR(before.point.z(), std::sqrt(1 - 0.05), 0.01);
    EXPECT_NEAR(after.point.z(), std::sqrt(9 - 0.05), 0.03);
}

TEST(RayTree, GrowsUnderManyThreads)
{
    const Mesh mesh = make_torus_knot_mesh(2, 3, 1, 0.4, 0.2, 20000);
    const auto hits_of = [&](RayTree& tree, std::uint64_t from) {
        RayWalk walk;
        std::uint64_t sum = 0;
        for (std::uint64_t seed = from; seed < from + 400; ++seed) {
            const Segment segment = draw(mesh, 9 * (seed % 500) + 7);
            walk.walk(tree, segment, [&](std::uint32_t triangle, bool) {
                sum += segment_meets(segment, tree.tree().corners(triangle)) ? triangle + 1 : 0;
                return 1.0;
            });
        }
        return sum;
    };
    ObbTree alone(mesh), shared(mesh);
    RayTree tree(alone), of_all(shared);
    std::array<std::uint64_t, 4> sums{};
    std::vector<std::thread> threads;
    for (std::size_t k = 0; k < sums.size(); ++k)
        threads.emplace_back([&, k] { sums[k] = hits_of(of_all, 100 * k); });
    for (std::thread& thread : threads) thread.join();
    for (std::size_t k = 0; k < sums.size(); ++k) EXPECT_EQ(sums[k], hits_of(tree, 100 * k));
    EXPECT_EQ(of_all.validate(), "");
}

TEST(RayTree, KernelsAgree)
{
    if (instruction_set() < InstructionSet::avx2) GTEST_SKIP() << "no AVX2";
    for (std::uint64_t seed = 0; seed < 3000; ++seed) {
        RayNode node{};
        RayTriangles row{};
        RayLine line{};
        float point[3], direction[3];
        for (std::uint64_t i = 0; i < 3; ++i) {
            for (std::uint64_t k = 0; k < 8; ++k) {
                node.low[i][k] = float(2 * u01(seed, i, k) - 1);
                node.high[i][k] = node.low[i][k] + float(u01(seed, 10 + i, k));
                for (std::uint64_t c = 0; c < 3; ++c)
                    row.corner[c][i][k] = std::int16_t(65534 * (u01(seed, 20 + c, 8 * i + k) - 0.5));
            }
            const double d = 2 * u01(seed, 30, i) - 1;
            line.inverse[i] = float(1 / d);
            line.from_less[i] = float(-2 * d - 1e-6), line.from_more[i] = float(-2 * d + 1e-6);
            point[i] = float(20000 * (u01(seed, 31, i) - 0.5)), direction[i] = float(d);
        }
        float entry[8], same[8];
        const unsigned met = baseline::ray_kernel().boxes(node, line, 3, entry);
        EXPECT_EQ(avx2::ray_kernel().boxes(node, line, 3, same), met);
        EXPECT_TRUE(std::equal(entry, entry + 8, same));
        const RayHits one = baseline::ray_kernel().triangles(row, point, direction, 1e5f),
                      two = avx2::ray_kernel().triangles(row, point, direction, 1e5f);
        EXPECT_EQ(one.possible, two.possible);
        EXPECT_EQ(one.certain, two.certain);
        EXPECT_EQ(one.certain & ~one.possible, 0u);
    }
}

} // namespace
} // namespace oncollide::ray_tree_test
