// Segments against models, compared with tests of every triangle and cell.
#include <algorithm>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/rays/segment_query.hpp>
#include <oncollide/narrowphase/rays/segment_tests.hpp>
#include <oncollide/narrowphase/shapes/cell_test.hpp>
#include <oncollide/pipeline/models/model_store.hpp>

#include "every_kind.hpp"
#include "verify/oracle/segment_truth.hpp"

namespace oncollide::segment_query_test {
namespace {

using Eigen::Vector3d;

/// All triangles and cells of a model, one after the other.
class Everything {
public:
    explicit Everything(const Model& model)
    {
        const auto add = [&](const Mesh& mesh) {
            for (const Triangle& t : mesh.triangles)
                triangles.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
        };
        if (const Terrain* terrain = model.terrain())
            add(mesh_of(*terrain));
        else if (const OccupancyMap* map = model.map())
            map->each_cell(map->bounds(), [&](const MapCell& cell) {
                cells.push_back(MapAccess::box(*map, cell)), names.emplace_back(cell);
                return true;
            });
        else
            add(*model.surface_mesh());
        if (model.is_mesh())
            for (std::uint32_t i = 0; i < triangles.size(); ++i) names.emplace_back(i);
    }
    bool meet(const Segment& s) const
    {
        const TrianglePoints flat{s.from, s.to, s.to};
        return std::ranges::any_of(triangles, [&](const auto& t) { return triangles_meet(flat, t); }) ||
               std::ranges::any_of(cells, [&](const Aabb& cell) { return cell_meets(cell, flat); });
    }
    /// A corner of some part.
    Vector3d corner(std::uint64_t seed) const
    {
        const auto pick = [&](std::uint64_t k, std::size_t count) {
            return static_cast<std::size_t>(u01(seed, 60, k) * double(count));
        };
        if (!triangles.empty()) return triangles[pick(0, triangles.size())][pick(1, 3)];
        return corner_of(cells[pick(0, cells.size())], static_cast<unsigned>(pick(1, 8)));
    }

    std::vector<TrianglePoints> triangles;
    std::vector<Aabb> cells;
    std::vector<BodyPart> names; ///< of meshes and maps
};

Vector3d random_point(std::uint64_t seed, std::uint64_t k, double reach)
{
    return reach * (2 * Vector3d(u01(seed, 70 + k, 0), u01(seed, 70 + k, 1), u01(seed, 70 + k, 2)).array() - 1);
}

/// Ordinary segments, and segments that begin, end or pass at corners, run along edges or faces, are points, are tiny,
/// or begin or end far away.
Segment draw(const Everything& all, std::uint64_t seed)
{
    const Vector3d a = all.corner(3 * seed), b = all.corner(3 * seed + 1), r = random_point(seed, 0, 1.5),
                   q = random_point(seed, 1, 1.5);
    switch (seed % 10) {
    case 0:
        return {a, b};
    case 1:
        return {a - 2 * (b - a), b + 2 * (b - a)};
    case 2:
        return {r, 2 * a - r}; // through a corner, up to rounding
    case 3:
        return {a, a};
    case 4:
        return {a + Vector3d(-4, 0, 0), a + Vector3d(4, 0, 0)};
    case 5:
        return {r + 1e8 * (r - q), q};
    case 6:
        return {r, r + 1e-9 * q};
    case 7:
        return {a + Vector3d(0, 0, 0x1p-40), a + Vector3d(0, 3, 0x1p-40)};
    case 8:
        return {a + Vector3d(0, -5, 5), a + Vector3d(0, 5, -5)}; // exact for coordinates in eighths
    default:
        return {r, q};
    }
}

TEST(SegmentQuery, MeetsWhatOneOfAllPartsMeets)
{
    std::map<std::size_t, std::array<int, 2>> counts;
    SegmentQuery query;
    const Settings settings;
    for (const std::size_t kind : {0, 1, 2, 4, 7})
        for (std::uint64_t seed = 0; seed < 24; ++seed) {
            ModelStore store(settings, make_cpu_backend());
            Model& model =
                store[store.add(std::make_shared<const Geometry>(Geometry{"", draw_geometry(kind, seed), ""}))];
            ASSERT_TRUE(SegmentQuery::covers(model.kind()));
            const Everything all(model);
            if (model.has_triangles() && (kind == 0 || seed % 2)) store.obb_tree(model, 0);
            for (std::uint64_t k = 0; k < 200; ++k) {
                const Segment segment = draw(all, 1000 * seed + k);
                const bool expected = all.meet(segment);
                EXPECT_EQ(query.meets(model, segment), expected) << every_kind[kind] << " " << seed << " " << k;
                EXPECT_EQ(query.meets(model, {segment.to, segment.from}), expected) << every_kind[kind] << " " << k;
                ++counts[kind][expected];
            }
        }
    for (const auto& [kind, count] : counts) EXPECT_GT(std::min(count[0], count[1]), 500) << every_kind[kind];
}

/// Compares the first point with rational arithmetic.
void expect_first(SegmentQuery& query, Model& model, const Everything& all, const Segment& segment)
{
    const std::optional<SegmentHit> hit = query.first(model, segment, false);
    ASSERT_EQ(hit.has_value(), query.decide(model, segment, false).verdict == Verdict::colliding);
    std::vector<oracle::SegmentTruth> parts(all.triangles.size() + all.cells.size());
    oracle::SegmentTruth first;
    for (std::size_t i = 0; i < all.triangles.size(); ++i)
        parts[i].add(segment, all.triangles[i]), first.add(segment, all.triangles[i]);
    for (std::size_t i = 0; i < all.cells.size(); ++i)
        parts[i].add(segment, all.cells[i]), first.add(segment, all.cells[i]);
    const auto behind = [&](const auto& t) { return orient3d(t[0], t[1], t[2], segment.from) <= 0; };
    if (model.kind() == Kind::polytope && std::ranges::all_of(all.triangles, behind)) first.add_start();
    ASSERT_EQ(hit.has_value(), first.met());
    if (!hit) return;

    const auto& [lower, upper, certain] = hit->entry;
    EXPECT_TRUE(certain && first.within(lower, upper)) << lower << " to " << upper;
    EXPECT_LE(upper - lower, 0x1p-46 * upper + 0x1p-999);
    EXPECT_NEAR(hit->normal.squaredNorm(), hit->normal.isZero(0) ? 0 : 1, 1e-14);
    EXPECT_LE(hit->normal.dot(segment.to - segment.from), 1e-14 * (segment.to - segment.from).norm());
    EXPECT_EQ(query.first(model, segment, false, upper)->part, hit->part);
    if (lower > 0) {
        EXPECT_FALSE(query.first(model, segment, false, 0.5 * lower)) << "nothing is nearer";
    }
    for (std::size_t i = 0; i < all.names.size(); ++i) {
        if (parts[i].equals(first)) {
            EXPECT_LE(hit->part, all.names[i]) << "the smallest of the nearest parts";
        }
        if (all.names[i] == hit->part) {
            EXPECT_TRUE(parts[i].within(lower, upper * (1 + 0x1p-45)));
        }
    }
}

TEST(SegmentQuery, TheFirstPointIsThatOfRationalArithmetic)
{
    SegmentQuery query;
    const Settings settings;
    for (const std::size_t kind : {0, 1, 2, 4, 7})
        for (std::uint64_t seed = 0; seed < 6; ++seed) {
            ModelStore store(settings, make_cpu_backend());
            Model& model =
                store[store.add(std::make_shared<const Geometry>(Geometry{"", draw_geometry(kind, seed), ""}))];
            const Everything all(model);
            if (model.has_triangles() && (kind == 0 || seed % 2)) store.obb_tree(model, 0);
            for (std::uint64_t k = 0; k < 60; ++k) {
                const Segment segment = draw(all, 1000 * seed + k);
                SCOPED_TRACE(std::string(every_kind[kind]) + " " + std::to_string(seed) + " " + std::to_string(k));
                expect_first(query, model, all, segment);
                expect_first(query, model, all, {segment.to, segment.from});
            }
        }
}

/// How far a point is outside a round shape: > 0 outside, about metres near the surface.
double outside(const Shape& shape, const Vector3d& p)
{
    const double across = std::hypot(p.x(), p.y());
    if (const auto* s = std::get_if<Sphere>(&shape)) return p.norm() - s->radius;
    if (const auto* c = std::get_if<Capsule>(&shape))
        return std::hypot(across, std::max(std::abs(p.z()) - c->length / 2, 0.0)) - c->radius;
    if (const auto* c = std::get_if<Cylinder>(&shape))
        return std::max(across - c->radius, std::abs(p.z()) - c->length / 2);
    if (const auto* c = std::get_if<Cone>(&shape))
        return std::max(-c->length / 2 - p.z(), across - c->radius * (0.5 - p.z() / c->length));
    return p.cwiseQuotient(std::get<Ellipsoid>(shape).semi_axes).norm() - 1;
}

TEST(SegmentQuery, TheFirstPointInARoundShapeIsOnItsSurface)
{
    SegmentQuery query;
    for (const std::size_t kind : {3, 5, 6, 8, 9}) {
        int hits = 0, inside = 0, wide = 0;
        for (std::uint64_t seed = 0; seed < 600; ++seed) {
            Model model(std::make_shared<const Geometry>(Geometry{"", draw_geometry(kind, seed % 10), ""}));
            const Shape& shape = *model.shape();
            const Segment segment{random_point(seed, 5, seed % 4 ? 2 : 0.3), random_point(seed, 6, 2)};
            const auto at = [&](double t) { return Vector3d((1 - t) * segment.from + t * segment.to); };
            SCOPED_TRACE(std::string(every_kind[kind]) + " " + std::to_string(seed));
            const std::optional<SegmentHit> hit = query.first(model, segment, false);
            const double clear = hit ? hit->entry.lower : 1;
            for (int k = 0; k <= 200 && clear > 0; ++k) EXPECT_GT(outside(shape, at(clear * k / 200)), -1e-11);
            if (!hit) continue;
            ASSERT_TRUE(hit->entry.certain);
            ++hits, inside += hit->entry.upper == 0;
            if (hit->entry.upper == 0) {
                EXPECT_LE(outside(shape, segment.from), 1e-12);
                EXPECT_TRUE(hit->normal.isZero(0));
                continue;
            }
            EXPECT_NEAR(outside(shape, at(hit->entry.upper)), 0, 1e-11);
            EXPECT_LE(hit->entry.upper - hit->entry.lower, 0x1p-36);
            wide += hit->entry.upper - hit->entry.lower > 0x1p-40;
            EXPECT_NEAR(hit->normal.norm(), 1, 1e-12);
            EXPECT_LE(hit->normal.dot(segment.to - segment.from), 1e-6);
        }
        EXPECT_GT(hits, 70) << every_kind[kind];
        EXPECT_GT(inside, 5) << every_kind[kind];
        EXPECT_LT(wide, 5) << every_kind[kind] << ": grazed";
    }
    Model plane(std::make_shared<const Geometry>(Geometry{"", Shape(HalfSpace{}), ""}));
    const std::optional<SegmentHit> hit = query.first(plane, {{0, 0, 3}, {4, 0, -1}}, false);
    ASSERT_TRUE(hit && hit->entry.lower <= 0.75 && hit->entry.upper >= 0.75);
    EXPECT_EQ(hit->normal, Vector3d::UnitZ());
    EXPECT_FALSE(query.first(plane, {{0, 0, 3}, {4, 0, 1}}, false));
    EXPECT_EQ(query.first(plane, {{0, 0, 0}, {0, 0, 1}}, false)->entry.upper, 0) << "begins on the plane";
}

/// The approximate fraction at which a segment crosses the plane of a triangle.
double fraction_of(const Segment& s, const TrianglePoints& t)
{
    const Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
    return normal.dot(t[0] - s.from) / normal.dot(s.to - s.from);
}

TEST(SegmentQuery, TheWalkFindsTheNearestAndVisitsFew)
{
    const Terrain hills = make_hills(300, 200, 1, 30, 3);
    const Mesh mesh = mesh_of(hills);
    TerrainTree heights(hills);
    ObbTree tree(mesh);
    SegmentWalk<TerrainTree> over_heights;
    SegmentWalk<ObbTree> over_mesh;
    int hits = 0, visited = 0;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        const auto at = [&](std::uint64_t k, double z) {
            return Vector3d(300 * u01(seed, k, 0), 200 * u01(seed, k, 1), z * u01(seed, k, 2));
        };
        const Segment segment{at(0, 40), at(1, 20)};
        double nearest = 2;
        for (const Triangle& t : mesh.triangles) {
            const TrianglePoints points{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
            if (segment_meets(segment, points)) nearest = std::min(nearest, fraction_of(segment, points));
        }
        const auto walk = [&](auto& walker, auto& hierarchy, auto points_of) {
            double least = 2;
            walker.walk(hierarchy, segment, [&](std::uint32_t triangle) {
                ++visited;
                const TrianglePoints points = points_of(triangle);
                if (segment_meets(segment, points)) least = std::min(least, fraction_of(segment, points));
                return std::min(least, 1.0);
            });
            return least;
        };
        EXPECT_EQ(walk(over_mesh, tree, [&](std::uint32_t t) { return tree.corners(t); }), nearest) << seed;
        EXPECT_EQ(walk(over_heights, heights, [&](std::uint32_t t) { return heights.points(t); }), nearest) << seed;
        hits += nearest < 2;
    }
    EXPECT_GT(hits, 30);
    EXPECT_LT(hits, 60);
    EXPECT_LT(visited, 120 * 60) << "of " << mesh.triangles.size() << " triangles";
}

/// A box of a node as its kernel reads it: whether it holds a point of the tree's frame, except for `slack`.
bool holds(const OpenBoxes& boxes, unsigned k, const Vector3d& point, double slack)
{
    const Vector3d to = point - Vector3d(boxes.c[0][k], boxes.c[1][k], boxes.c[2][k]);
    for (const int i : {0, 1, 2})
        if (std::abs(to.dot(Vector3d(boxes.axis[i][0][k], boxes.axis[i][1][k], boxes.axis[i][2][k]))) >
            boxes.h[i][k] + slack)
            return false;
    return true;
}

TEST(SegmentQuery, ANodesBoxesAreThoseThatTheSegmentMeetsOnEveryInstructionSet)
{
    std::vector<OrientedBoxKernel> kernels{baseline::oriented_box_kernel()};
    if (instruction_set() >= InstructionSet::avx2) kernels.push_back(avx2::oriented_box_kernel());
    if (instruction_set() >= InstructionSet::avx512) kernels.push_back(avx512::oriented_box_kernel());
    const Mesh hills = mesh_of(make_hills(40, 30, 1, 9, 3)), torus = make_torus_mesh(2, 0.5, 3000);
    int met = 0, missed = 0;
    for (const Mesh* mesh : {&hills, &torus}) { // boxes along the axes, and others
        ObbTree tree(*mesh);
        ObbTree::Node node = tree.below_root();
        for (std::uint64_t seed = 0; seed < 4000; ++seed) {
            const auto draw = [&](std::uint64_t k) { return u01(seed, 70, k); };
            const auto point = [&](std::uint64_t k) {
                return Vector3d(
                    mesh->bounds.min +
                    (mesh->bounds.max - mesh->bounds.min).cwiseProduct(Vector3d(draw(k), draw(k + 1), draw(k + 2))));
            };
            const auto lane = static_cast<unsigned>(draw(9) * tree.node(node).lanes);
            node = tree.node(node).leaves >> lane & 1 ? tree.below_root() : tree.child(node, lane);
            Segment segment{point(0), point(3)};
            segment.to[2] = segment.from[2] + (seed % 3) * (segment.to[2] - segment.from[2]); // flat, and longer
            const std::optional<SegmentPart> part = part_in(segment, mesh->bounds);
            if (!part) continue;
            const SegmentLine line = line_of(*part, tree.centre(), 4 * tree.radius());
            OpenBoxes boxes;
            const LaneMasks masks = tree.open(node, nullptr, boxes);
            float entry[8], same[8];
            unsigned leaves;
            const unsigned found = tree.on_segment(node, line, entry, leaves);
            EXPECT_EQ(leaves, masks.leaves);
            for (const OrientedBoxKernel& kernel : kernels) {
                EXPECT_EQ(kernel.node_on_segment(tree.node(node), line, same), found);
                EXPECT_TRUE(std::equal(entry, entry + tree.node(node).lanes, same));
            }
            for (unsigned k = 0; k < 8; ++k) {
                bool inside = false, near = false;
                for (double t = -1; t <= 1; t += 0x1p-7) {
                    const Vector3d at = part->middle + t * part->half - tree.centre();
                    if (k < tree.node(node).lanes && holds(boxes, k, at, 0)) {
                        inside = true;
                        EXPECT_LE(entry[k], t);
                    }
                    near |= holds(boxes, k, at, 0.02 * tree.radius());
                }
                EXPECT_TRUE(!inside || found >> k & 1) << seed << ' ' << k;
                EXPECT_TRUE(near || !(found >> k & 1)) << seed << ' ' << k;
                (found >> k & 1 ? met : missed)++;
            }
        }
    }
    EXPECT_GT(met, 2000);
    EXPECT_GT(missed, 2000);
}

TEST(SegmentQuery, DecidesAtCornersAndEdgesExactly)
{
    const TrianglePoints triangle{Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0)};
    const auto meets = [&](const Vector3d& from, const Vector3d& to) { return segment_meets({from, to}, triangle); };
    EXPECT_TRUE(meets({0.25, 0.25, 1}, {0.25, 0.25, -1}));
    EXPECT_TRUE(meets({0.5, 0.5, 1}, {0.5, 0.5, -1})) << "through an edge";
    EXPECT_FALSE(meets({0.5, 0.5 + 0x1p-53, 1}, {0.5, 0.5 + 0x1p-53, -1}));
    EXPECT_TRUE(meets({1, 0, 1}, {1, 0, -1})) << "through a corner";
    EXPECT_FALSE(meets({1 + 0x1p-52, 0, 1}, {1 + 0x1p-52, 0, -1}));
    EXPECT_TRUE(meets({0.25, 0.25, 1}, {0.25, 0.25, 0})) << "ends on the face";
    EXPECT_FALSE(meets({0.25, 0.25, 1}, {0.25, 0.25, 0x1p-1074}));
    EXPECT_TRUE(meets({-1, 0.25, 0}, {2, 0.25, 0})) << "in the plane";
    EXPECT_FALSE(meets({-1, 0.25, 0}, {-0x1p-1074, 0.25, 0}));
    EXPECT_TRUE(meets({0.25, 0.25, 0}, {0.25, 0.25, 0})) << "a point";
}

} // namespace
} // namespace oncollide::segment_query_test
