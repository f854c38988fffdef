// The boxes of OBB trees hold their triangles, with every kernel.
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <numeric>
#include <thread>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/obb/fits/triangle_parts.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>

#include "narrowphase/mesh_cases.hpp"

namespace oncollide::mesh_cases {
namespace {

struct Kernel {
    std::string name;
    OrientedBoxKernel kernel;
};

std::vector<Kernel> kernels()
{
    std::vector<Kernel> all{{"baseline", baseline::oriented_box_kernel()}};
    if (instruction_set() >= InstructionSet::avx2) all.push_back({"avx2", avx2::oriented_box_kernel()});
    if (instruction_set() >= InstructionSet::avx512) all.push_back({"avx512", avx512::oriented_box_kernel()});
    return all;
}

/// Upper bound on the distance of a point beyond the faces of box k.
double beyond(const OpenBoxes& boxes, unsigned k, const Vector3d& p)
{
    double most = -std::numeric_limits<double>::infinity();
    const Vector3d d = p - Vector3d(boxes.c[0][k], boxes.c[1][k], boxes.c[2][k]);
    for (int i = 0; i < 3; ++i) {
        const Vector3d axis(boxes.axis[i][0][k], boxes.axis[i][1][k], boxes.axis[i][2][k]);
        EXPECT_NEAR(axis.norm(), 1, 1e-5);
        most = std::max(most, std::abs(axis.dot(d)) - double(boxes.h[i][k]));
    }
    return most;
}

TEST(ObbTree, HoldsEveryTriangleInEachOfItsBoxes)
{
    for (const Case& c : cases())
        for (const Mesh* mesh : {&c.a, &c.b}) {
            ObbTree tree(*mesh);
            const Isometry3d pose = random_pose(5, tree.radius());
            BoxPlacement place{{}, true, {}, {}};
            for (int i = 0; i < 9; ++i) place.rotation[i] = static_cast<float>(pose.linear()(i / 3, i % 3));
            for (int i = 0; i < 3; ++i) place.translation[i] = static_cast<float>(pose.translation()[i]);
            const double rounding = 0x1p-17 * tree.radius() + 0x1p-48 * tree.centre().norm();
            std::vector<int> leaves(mesh->triangles.size());
            for (std::vector<std::uint32_t> open{ObbTree::root}; !open.empty();) {
                const std::uint32_t index = open.back();
                open.pop_back();
                const BoxNode node = tree.node(index);
                for (unsigned k = 0; k < node.lanes; ++k)
                    if (tree.count_of(index, k) > ObbTree::leaf_triangles) open.push_back(tree.child(index, k));
                for (const Kernel& kernel : kernels())
                    for (const BoxPlacement* placement : {static_cast<BoxPlacement*>(nullptr), &place}) {
                        OpenBoxes boxes;
                        kernel.kernel.open(node, placement, boxes);
                        for (unsigned k = 0; k < node.lanes; ++k)
                            for (std::uint32_t i = 0; i < tree.count_of(index, k); ++i)
                                for (std::uint32_t v : mesh->triangles[tree.triangle(tree.begin_of(index, k) + i)]) {
                                    const Vector3d p = mesh->vertices[v] - tree.centre();
                                    EXPECT_LE(beyond(boxes, k, placement ? pose * p : p), rounding)
                                        << c.name << ' ' << kernel.name;
                                }
                    }
                for (unsigned k = 0; k < node.lanes; ++k)
                    if (node.leaves >> k & 1)
                        for (const std::uint32_t triangle : tree.primitives(index, k)) ++leaves[triangle];
                for (unsigned k = 0; k < node.lanes; ++k) {
                    if (!(node.leaves & ~node.singles & 1u << k)) continue;
                    const ObbTree::Node parts = tree.child(index, k);
                    OpenBoxes boxes;
                    tree.open(parts, nullptr, boxes);
                    for (unsigned i = 0; i < 2; ++i) {
                        ASSERT_EQ(tree.primitives(parts, i).size(), 1u);
                        const std::uint32_t triangle = tree.primitives(parts, i)[0];
                        EXPECT_EQ(triangle, tree.primitives(index, k)[i]);
                        for (const std::uint32_t v : mesh->triangles[triangle])
                            EXPECT_LE(beyond(boxes, i, mesh->vertices[v] - tree.centre()), rounding);
                    }
                }
            }
            EXPECT_EQ(leaves, std::vector<int>(leaves.size(), 1)) << "each triangle in one leaf";
        }
}

/// Eight boxes of various sizes and flatness.
OpenBoxes random_boxes(std::uint64_t seed)
{
    OpenBoxes boxes;
    boxes.margin = 0;
    for (std::uint64_t k = 0; k < 8; ++k) {
        const Isometry3d pose = random_pose(100 * seed + k, 1);
        for (int i = 0; i < 3; ++i) {
            boxes.c[i][k] = static_cast<float>(pose.translation()[i]);
            for (int j = 0; j < 3; ++j) boxes.axis[j][i][k] = static_cast<float>(pose.linear()(i, j));
            const double h = u01(seed, 4, 3 * k + std::uint64_t(i));
            boxes.h[i][k] = h < 0.3 ? 0 : static_cast<float>(std::pow(h, 3));
        }
    }
    return boxes;
}

Vector3d point_in(const OpenBoxes& boxes, unsigned k, std::uint64_t seed)
{
    Vector3d p(boxes.c[0][k], boxes.c[1][k], boxes.c[2][k]);
    for (int j = 0; j < 3; ++j) {
        const double t = std::clamp(3 * u01(seed, 5, std::uint64_t(j)) - 1.5, -1.0, 1.0); // often on a face
        for (int i = 0; i < 3; ++i) p[i] += t * double(boxes.h[j][k]) * double(boxes.axis[j][i][k]);
    }
    return p;
}

TEST(OrientedBoxKernel, NeverShowsAGapLargerThanTheDistance)
{
    int touching = 0, apart = 0;
    for (std::uint64_t seed = 0; seed < 400; ++seed) {
        OpenBoxes boxes = random_boxes(seed);
        const OpenBoxes other = random_boxes(seed + 1000);
        const unsigned k = seed % 8;
        // Half of the boxes are moved so that one of their points is on a point of the other box.
        for (unsigned lane = 0; lane < 8; lane += 2) {
            const Vector3d by = point_in(other, k, seed + lane) - point_in(boxes, lane, seed + 31);
            for (int i = 0; i < 3; ++i) boxes.c[i][lane] += static_cast<float>(by[i]);
        }
        const Vector3d line = (point_in(boxes, seed % 5, seed) - point_in(other, k, seed + 5)).normalized();
        const auto along = [&](const auto& v) { return line.x() * v[0][k] + line.y() * v[1][k] + line.z() * v[2][k]; };
        BoxLine reach{{float(line.x()), float(line.y()), float(line.z())}, float(along(other.c))};
        for (int i = 0; i < 3; ++i) reach.other_reach += float(other.h[i][k] * std::abs(along(other.axis[i])));
        for (const bool far : {false, true}) {
            float first_gaps[8];
            for (const Kernel& kernel : kernels()) {
                float gaps[8], nearest[8];
                std::fill(std::begin(nearest), std::end(nearest), std::numeric_limits<float>::infinity());
                const auto& compare = kernel.kernel;
                const unsigned near = far ? compare.compare_far(boxes, other, k, reach, 1e-5f, gaps, nearest)
                                          : compare.compare(boxes, other, k, 1e-5f, gaps, nearest);
                for (unsigned lane = 0; lane < 8; ++lane) {
                    EXPECT_EQ(near >> lane & 1, unsigned(gaps[lane] <= 1e-5f));
                    if (!(near >> lane & 1)) {
                        EXPECT_EQ(nearest[lane], gaps[lane]);
                    } else {
                        EXPECT_EQ(nearest[lane], std::numeric_limits<float>::infinity());
                    }
                    if (lane % 2 == 0) {
                        EXPECT_TRUE(near >> lane & 1) << kernel.name << ", they share a point";
                    }
                    (near >> lane & 1 ? touching : apart) += 1;
                    for (std::uint64_t sample = 0; sample < 20; ++sample) {
                        const double distance =
                            (point_in(boxes, lane, 77 * seed + sample) - point_in(other, k, 99 * seed + 5 * sample + 3))
                                .norm();
                        EXPECT_LE(gaps[lane], distance + 1e-5) << kernel.name;
                    }
                }
                if (!far) { // the order: the same boxes, and the distance of their centres
                    float order[8], again[8];
                    std::fill(std::begin(again), std::end(again), std::numeric_limits<float>::infinity());
                    EXPECT_EQ(compare.compare_likely(boxes, other, k, 1e-5f, order, again), near) << kernel.name;
                    EXPECT_TRUE(std::equal(std::begin(again), std::end(again), nearest)) << kernel.name;
                    for (unsigned lane = 0; lane < 8; ++lane) {
                        const float x = boxes.c[0][lane] - other.c[0][k], y = boxes.c[1][lane] - other.c[1][k],
                                    z = boxes.c[2][lane] - other.c[2][k];
                        EXPECT_EQ(order[lane], gaps[lane] + 2 * std::sqrt(x * x + y * y + z * z)) << kernel.name;
                    }
                }
                if (kernel.name == "baseline") std::copy(std::begin(gaps), std::end(gaps), first_gaps);
                EXPECT_TRUE(std::equal(std::begin(gaps), std::end(gaps), first_gaps)) << kernel.name << ": other bits";
            }
        }
    }
    EXPECT_GT(touching, 1000);
    EXPECT_GT(apart, 1000);
}

TEST(OrientedBoxKernel, MeasuresThePointsDistances)
{
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        const OpenBoxes boxes = random_boxes(seed);
        const float point[3] = {float(4 * u01(seed, 5, 0) - 2), float(4 * u01(seed, 5, 1) - 2),
                                float(4 * u01(seed, 5, 2) - 2)};
        for (const Kernel& kernel : kernels()) {
            float distance2[8];
            kernel.kernel.from_point(boxes, point, distance2);
            for (unsigned lane = 0; lane < 8; ++lane) {
                const Vector3d from = Vector3d(point[0], point[1], point[2]) -
                                      Vector3d(boxes.c[0][lane], boxes.c[1][lane], boxes.c[2][lane]);
                double expected = 0;
                for (int j = 0; j < 3; ++j) {
                    const Vector3d axis(boxes.axis[j][0][lane], boxes.axis[j][1][lane], boxes.axis[j][2][lane]);
                    const double out = std::max(0.0, std::abs(axis.dot(from)) - double(boxes.h[j][lane]));
                    expected += out * out;
                }
                EXPECT_NEAR(distance2[lane], expected, 1e-5 * (1 + expected)) << kernel.name;
            }
        }
    }
}

TEST(OrientedBoxKernel, NeverReachesUnusedLanes)
{
    for (const float size : {1e-9f, 1.0f, 1e9f, 1e15f}) {
        OpenBoxes boxes = random_boxes(3), other = random_boxes(4);
        for (int i = 0; i < 3; ++i)
            for (int lane = 0; lane < 8; ++lane) other.h[i][lane] *= size;
        for (int i = 0; i < 3; ++i) boxes.h[i][5] = 0;
        boxes.c[0][5] = 1e30f, boxes.size[5] = 0;
        for (const Kernel& kernel : kernels())
            for (const float direction : {-1.0f, 1.0f}) {
                float gaps[8], nearest[8] = {};
                const BoxLine line{{direction, 0, 0}, 0};
                EXPECT_FALSE(kernel.kernel.compare_far(boxes, other, 2, line, 0x1p90f, gaps, nearest) >> 5 & 1)
                    << kernel.name << ' ' << size;
            }
    }
}

/// Boxes that only the nine cross products separate: two flat, long boxes that cross like the strokes of a plus.
TEST(OrientedBoxKernel, PartsBoxesByTheirEdges)
{
    OpenBoxes boxes{}, other{};
    for (int j = 0; j < 3; ++j)
        for (int lane = 0; lane < 8; ++lane) boxes.axis[j][j][lane] = other.axis[j][j][lane] = 1;
    const float s = std::sqrt(0.5f);
    for (int lane = 0; lane < 8; ++lane) {
        // Both stand on an edge: one along x, below; one along y, above.
        boxes.axis[1][1][lane] = s, boxes.axis[1][2][lane] = s, boxes.axis[2][1][lane] = -s, boxes.axis[2][2][lane] = s;
        other.axis[0][0][lane] = s, other.axis[0][2][lane] = -s, other.axis[2][0][lane] = s, other.axis[2][2][lane] = s;
        boxes.h[0][lane] = 5, boxes.h[1][lane] = boxes.h[2][lane] = 1;
        other.h[1][lane] = 5, other.h[0][lane] = other.h[2][lane] = 1;
        other.c[2][lane] = 2.9f;
    }
    for (const Kernel& kernel : kernels()) {
        float gaps[8], nearest[8] = {9, 9, 9, 9, 9, 9, 9, 9};
        EXPECT_EQ(kernel.kernel.compare(boxes, other, 3, 0, gaps, nearest), 0u) << kernel.name;
        EXPECT_NEAR(gaps[0], 2.9 - 2 * std::sqrt(2.0), 1e-5) << kernel.name;
    }
}

/// The triangles are divided by halving, sorting or cutting between slices; also with many triangles at one position
/// along an axis.
TEST(TriangleParts, DoNotDependOnTheOrderOfTheTriangles)
{
    const Mesh meshes[] = {make_terrain_mesh(10, 1, 20, 3), make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 800),
                           scaled(make_sphere_mesh(1, 500), 1e-44), flat_copies()};
    for (const Mesh& mesh : meshes)
        for (const std::size_t size : {9u, 16u, 17u, 40u, 64u, 65u, 129u, 400u}) {
            if (size > mesh.triangles.size()) continue;
            std::vector<std::uint32_t> triangles(size);
            std::iota(triangles.begin(), triangles.end(), 0u);
            TriangleParts parts;
            const auto split = [&] {
                parts.start({mesh.vertices.data(), mesh.triangles.data()}, mesh.bounds.centre(), triangles);
                parts.split(8);
                std::vector<std::vector<std::uint32_t>> sets;
                for (std::size_t k = 0, i = 0; k < 8; ++k) {
                    sets.emplace_back();
                    for (; i < parts.end(unsigned(k)); ++i) sets.back().push_back(parts.triangle(i));
                    std::ranges::sort(sets.back());
                }
                return sets;
            };
            const auto expected = split();
            std::size_t all = 0;
            for (const auto& set : expected) {
                EXPECT_FALSE(set.empty());
                all += set.size();
            }
            EXPECT_EQ(all, size);
            for (std::uint64_t seed = 0; seed < 5; ++seed) {
                for (std::size_t i = size; i-- > 1;)
                    std::swap(triangles[i], triangles[std::size_t(u01(seed, i, 0) * double(i + 1))]);
                EXPECT_EQ(split(), expected) << mesh.triangles.size() << ", " << size << " triangles";
            }
        }
}

/// Expects that every corner of the triangles is in its box, and that no box is larger than necessary.
/// @param thickness  in units of the triangle's size: wider slivers count as lines
void expect_boxes_of(std::span<const TrianglePoints> triangles, double thickness, const std::string& name)
{
    const Vector3d middle(0.3, -0.2, 0.1), from = middle + Vector3d(0.0625, 0.125, -0.5);
    const Isometry3d pose = random_pose(7, 1);
    BoxPlacement place{{0.0625f, 0.125f, -0.5f}, true, {}, {}};
    for (int i = 0; i < 9; ++i) place.rotation[i] = static_cast<float>(pose.linear()(i / 3, i % 3));
    for (int i = 0; i < 3; ++i) place.translation[i] = static_cast<float>(pose.translation()[i]);
    OpenBoxes first;
    for (const Kernel& kernel : kernels()) {
        SCOPED_TRACE(name + ' ' + kernel.name);
        OpenBoxes boxes{};
        kernel.kernel.open_triangles(row_of(triangles, from), &place, boxes);
        if (kernel.name == "baseline") first = boxes;
        EXPECT_EQ(std::memcmp(&first, &boxes, offsetof(OpenBoxes, margin) + sizeof boxes.margin), 0)
            << "the same on every instruction set";
        for (unsigned k = 0; k < 8; ++k) {
            if (k >= triangles.size()) {
                EXPECT_EQ(boxes.c[0][k], 1e30f);
                continue;
            }
            const TrianglePoints& t = triangles[k];
            const double size = std::max({(t[1] - t[0]).norm(), (t[2] - t[0]).norm(), (t[2] - t[1]).norm()});
            const double far = (t[0] - from).norm() + 1;
            for (const Vector3d& p : t) EXPECT_LE(beyond(boxes, k, pose * (p - from)), boxes.margin + 1e-6 * far);
            const Vector3d half(boxes.h[0][k], boxes.h[1][k], boxes.h[2][k]);
            EXPECT_LE(half.maxCoeff(), 0.50001 * size + 1e-30);
            EXPECT_LE(half.minCoeff(), thickness * size + 1e-30);
            Eigen::Matrix3d axes;
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) axes(j, i) = boxes.axis[i][j][k];
            EXPECT_LE((axes.transpose() * axes - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 2e-6);
            EXPECT_GT(axes.determinant(), 0);
        }
    }
}

TEST(OrientedBoxes, OfSingleTrianglesHoldTheirCorners)
{
    std::uint64_t seed = 1;
    for (int i = 0; i < 300; ++i) {
        std::vector<TrianglePoints> triangles(1 + std::size_t(i) % 8);
        for (TrianglePoints& t : triangles)
            for (Vector3d& p : t) p = random_pose(++seed, 1).translation();
        expect_boxes_of(triangles, 4e-6, "any " + std::to_string(i));
    }
    const Vector3d p(0.5, 0.25, -1), x(1, 2, 3), y(-2, 1, 0);
    for (const double size : {1e-28, 1e-18, 1e-9, 1.0, 1e9, 1e17}) {
        const auto triangles =
            std::vector<TrianglePoints>{{p, p, p},                                    // a point
                                        {p, p + size * x, p - size * x},              // a line
                                        {p, p, p + size * x},                         // the same with two equal corners
                                        {p, p + size * x, p - size * (x + 1e-7 * y)}, // needles
                                        {p, p + size * x, p - size * (x + 1e-4 * y)},
                                        {p, p + size * x, p - size * (x + 1e-2 * y)},
                                        {p, p + size * Vector3d::UnitX(), p - size * Vector3d::UnitX()},
                                        {p, p + size * Vector3d::UnitZ(), p - size * Vector3d(1e-12, 0, 1)}};
        for (const TrianglePoints& t : triangles) expect_boxes_of({&t, 1}, 0x1p-16, "size " + std::to_string(size));
    }
}

TEST(ObbTree, IsTheSameForManyThreadsAtOnce)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 3000);
    const Case c{"knots", knot, knot, 1.2};
    const std::vector<Isometry3d> poses = poses_of(c, 64);
    const auto answers = [&](int threads) {
        ObbTree a(c.a), b(c.b);
        std::vector<std::optional<TrianglePair>> all(poses.size());
        std::vector<std::thread> running;
        for (int t = 0; t < threads; ++t)
            running.emplace_back([&, t] {
                Traversal walk;
                for (std::size_t i = std::size_t(t); i < poses.size(); i += std::size_t(threads))
                    all[i] = walk.first_meeting(a, b, at(poses[i])).pair;
            });
        for (std::thread& thread : running) thread.join();
        return std::pair(all, std::pair(a.nodes(), b.nodes()));
    };
    EXPECT_EQ(answers(1), answers(4));
}

} // namespace
} // namespace oncollide::mesh_cases
