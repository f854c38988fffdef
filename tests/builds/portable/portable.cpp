// Prints a hash of the results of kernels and traversals, which must be equal for every compiler and processor. Meshes
// and poses use only random numbers and basic operations: mathematics libraries round sines differently.
#include <bit>
#include <cmath>
#include <cstdio>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>

namespace {

using namespace oncollide;
using Eigen::Vector3d;

struct Hash {
    std::uint64_t value = 0;
    void add(std::uint64_t x) { value = splitmix(value ^ x); }
    void add(double x) { add(std::bit_cast<std::uint64_t>(x)); }
};

Vector3d random_point(std::uint64_t seed, std::uint64_t i)
{
    return {u01(seed, i, 0) - 0.5, u01(seed, i, 1) - 0.5, u01(seed, i, 2) - 0.5};
}

Mesh random_triangles(int count, double edge, std::uint64_t seed)
{
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(count); ++i) {
        for (std::uint32_t k = 1; k < 4; ++k)
            vertices.push_back(random_point(seed, 4 * i) + edge * random_point(seed, 4 * i + k));
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return make_mesh("triangles", vertices, triangles);
}

/// A rotation from a quaternion, by basic operations and a square root.
Eigen::Isometry3d random_pose(std::uint64_t seed, double spread)
{
    double q[4], length = 0;
    for (std::uint64_t k = 0; k < 4; ++k) q[k] = u01(seed, 1, k) - 0.5, length += q[k] * q[k];
    length = std::sqrt(length);
    for (double& x : q) x /= length;
    const auto [w, x, y, z] = q;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z),
        1 - 2 * (x * x + z * z), 2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
    pose.translation() = spread * random_point(seed, 2);
    return pose;
}

void broad_phase(Hash& hash)
{
    std::vector<Aabb> boxes;
    std::vector<std::uint32_t> bodies;
    for (std::uint32_t i = 0; i < 3000; ++i) {
        boxes.emplace_back();
        boxes.back().add(10 * random_point(1, i));
        boxes.back().add(boxes.back().min + Vector3d(u01(2, i, 0), u01(2, i, 1), u01(2, i, 2)));
        bodies.push_back(i);
    }
    const BroadPhase::Options options{.margin = 0.01, .threads = 2};
    for (const auto& phase : {make_kd_tree(options), make_octree(options)}) {
        phase->add(bodies);
        for (const BodyPair& pair : phase->find_pairs({.boxes = boxes})) hash.add(std::uint64_t{pair.a} << 32 | pair.b);
    }
}

void oriented_boxes(Hash& hash)
{
    const Mesh mesh_a = random_triangles(900, 0.1, 3), mesh_b = random_triangles(500, 0.05, 4);
    ObbTree a(mesh_a), b(mesh_b);
    Traversal walk;
    std::vector<TrianglePair> meeting;
    for (std::uint64_t i = 0; i < 200; ++i) {
        const RelativePose b_to_a(random_pose(2 * i + 10, 1.5), random_pose(2 * i + 11, 1.5));
        const auto first = walk.first_meeting(a, b, b_to_a);
        hash.add(first.pair ? std::uint64_t{first.pair->a} << 32 | first.pair->b : ~std::uint64_t{0});
        walk.all_meeting(a, b, b_to_a, meeting);
        for (const TrianglePair& pair : meeting) hash.add(std::uint64_t{pair.a} << 32 | pair.b);
        const auto near = walk.near(a, b, b_to_a, 0.05, 0.01);
        hash.add(std::uint64_t{near.near}), hash.add(near.bound);
        const auto distance = walk.distance(a, b, b_to_a, 1e-3);
        hash.add(distance.lower), hash.add(distance.upper);
    }
    hash.add(walk.counts().box_rows), hash.add(walk.counts().triangles), hash.add(walk.counts().unsure);
}

void segments(Hash& hash)
{
    const Mesh mesh_a = random_triangles(600, 0.3, 7), mesh_b = random_triangles(600, 0.3, 8);
    ObbTree a(mesh_a), b(mesh_b);
    Traversal walk;
    std::vector<TrianglePair> meeting;
    for (std::uint64_t i = 0; i < 20; ++i) {
        const RelativePose b_to_a(random_pose(2 * i + 10, 0.5), random_pose(2 * i + 11, 0.5));
        walk.all_meeting(a, b, b_to_a, meeting);
        const RigidMap place{b_to_a.rotation.data(), b_to_a.translation.data()};
        for (std::size_t k = 0; k + 8 <= meeting.size(); k += 8) {
            SegmentsOfPairs common;
            const unsigned found = walk.walk().leaves().segments({&meeting[k], 8}, place, common);
            hash.add(std::uint64_t{found});
            for (unsigned rest = found; rest; rest &= rest - 1) {
                const int lane = __builtin_ctz(rest);
                for (int axis = 0; axis < 3; ++axis) {
                    hash.add(common.ends[0][axis][lane]), hash.add(common.ends[1][axis][lane]);
                    hash.add(common.normal_a[axis][lane]), hash.add(common.normal_b[axis][lane]);
                }
            }
        }
    }
}

void predicates(Hash& hash)
{
    for (std::uint64_t i = 0; i < 2000; ++i) {
        Vector3d p[4];
        for (std::uint64_t k = 0; k < 4; ++k) p[k] = random_point(5, 4 * i + k);
        p[3] = p[0] + 0.25 * (p[1] - p[0]) + 0.5 * (p[2] - p[0]); // on the plane up to rounding
        hash.add(static_cast<std::uint64_t>(orient3d(p[0], p[1], p[2], p[3]) + 1));
    }
}

void octants(Hash& hash)
{
    Surface surface;
    surface.root = {.centre = Vector3d::Zero(), .half = {1, 1, 1}, .radius = 1.75, .scale = 1};
    for (std::uint64_t i = 0; i < 400; ++i) {
        const Vector3d p = random_point(6, 3 * i), q = p + 0.3 * random_point(6, 3 * i + 1),
                       r = p + 0.3 * random_point(6, 3 * i + 2), normal = (q - p).cross(r - p);
        const Vector3d unit =
            normal / std::sqrt(normal.x() * normal.x() + normal.y() * normal.y() + normal.z() * normal.z());
        Primitive primitive;
        const Vector3d* const corners[] = {&p, &q, &r};
        for (int k = 0; k < 3; ++k) {
            for (int axis = 0; axis < 3; ++axis) primitive.point[k][axis] = static_cast<float>((*corners[k])[axis]);
            primitive.point[k][3] = static_cast<float>(unit[k]);
        }
        surface.primitives.push_back(primitive);
    }
    const auto backend = make_cpu_backend();
    backend->attach(0, std::move(surface));
    std::vector<OctantRow> rows{{0, root_cell, all_triangles, true}};
    for (int level = 0; level < 4; ++level) {
        std::vector<OctantResult> answers(rows.size());
        backend->run(rows, 2, answers);
        std::vector<OctantRow> below;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            hash.add(rows[i].cell << 8 | answers[i].grey);
            for (unsigned octant = 0; octant < 8; ++octant)
                if (answers[i].grey >> octant & 1)
                    below.push_back({0, rows[i].cell << 3 | octant, answers[i].list, true});
        }
        rows = below;
    }
}

} // namespace

int main()
{
    constexpr struct {
        const char* name;
        void (*run)(Hash&);
    } parts[] = {{"broad phase", broad_phase},
                 {"oriented boxes", oriented_boxes},
                 {"segments", segments},
                 {"predicates", predicates},
                 {"octants", octants}};
    for (const auto& part : parts) {
        Hash hash;
        part.run(hash);
        std::printf("%s %016llx\n", part.name, static_cast<unsigned long long>(hash.value));
    }
}
