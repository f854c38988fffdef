#include "verify/trials/manifold_trial.hpp"

#include <cmath>

#include <Eigen/Geometry>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/pipeline/world.hpp>

#include "verify/oracle/manifold_truth.hpp"

namespace oncollide::tools {

ManifoldTally& ManifoldTally::operator+=(const ManifoldTally& o)
{
    pairs += o.pairs, met += o.met, whole += o.whole, exact += o.exact, special += o.special, contacts += o.contacts;
    faults += o.faults, first += o.first;
    return *this;
}

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// A prism over a polygon, which is cut into triangles by the given corners.
Mesh prism(const std::vector<Vector2d>& outline, const std::vector<Triangle>& cut)
{
    const auto count = static_cast<std::uint32_t>(outline.size());
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (const double z : {-0.4, 0.4})
        for (const Vector2d& p : outline) vertices.emplace_back(p.x(), p.y(), z);
    for (const auto& [a, b, c] : cut)
        triangles.push_back({a, c, b}), triangles.push_back({a + count, b + count, c + count});
    for (std::uint32_t k = 0; k < count; ++k) {
        const std::uint32_t next = (k + 1) % count;
        triangles.push_back({k, next, next + count}), triangles.push_back({k, next + count, k + count});
    }
    return make_mesh("prism", std::move(vertices), std::move(triangles));
}

/// A form with corners of its own: closed, outward, about 1 m large.
Mesh draw_form(std::uint64_t seed)
{
    const auto draw = [&](std::uint64_t k) { return 2 * u01(seed, 11, k) - 1; };
    Mesh mesh;
    switch (std::uint64_t(4 * u01(seed, 12, 0))) {
    case 0:
        mesh = make_mesh("tetrahedron", {{0.6, 0, 0}, {-0.4, 0.5, 0}, {-0.4, -0.5, 0}, {0, 0, 0.7}},
                         {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
        break;
    case 1:
        mesh = prism({{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}, {{0, 1, 2}, {0, 2, 3}});
        break;
    case 2: // L
        mesh = prism({{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0}, {0, 0}, {0, 0.5}, {-0.5, 0.5}},
                     {{0, 1, 3}, {1, 2, 3}, {0, 3, 5}, {3, 4, 5}});
        break;
    default: // an arrowhead
        mesh = prism({{-0.6, -0.5}, {0, -0.2}, {0.6, -0.5}, {0, 0.7}}, {{0, 1, 3}, {1, 2, 3}});
    }
    std::uint64_t k = 0;
    const Vector3d axis = Vector3d(draw(900), draw(901), draw(902)).normalized();
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(3 * draw(903), axis).toRotationMatrix();
    for (Vector3d& v : mesh.vertices) v = turn * (v + 0.05 * Vector3d(draw(k), draw(k + 1), draw(k + 2))), k += 3;
    return make_mesh("form", mesh.vertices, mesh.triangles);
}

oracle::Surface surface_of(const Mesh& mesh)
{
    oracle::Surface surface;
    for (const auto& [a, b, c] : mesh.triangles)
        surface.push_back({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
    return surface;
}

void try_pair(std::uint64_t seed, ManifoldTally& tally)
{
    const Mesh a = draw_form(2 * seed + 1);
    Mesh b = draw_form(2 * seed + 2);
    const auto draw = [&](std::uint64_t k) { return 2 * u01(seed, 13, k) - 1; };
    // A corner of b is near a point of a: mostly shallow overlaps.
    const auto pick = [&](const Mesh& mesh, std::uint64_t k) {
        return mesh.vertices[std::size_t(u01(seed, 14, k) * double(mesh.vertices.size()))];
    };
    const double share = u01(seed, 15, 0);
    const Vector3d by = share * pick(a, 0) + (1 - share) * pick(a, 1) - pick(b, 2) +
                        std::pow(10, -3 * u01(seed, 15, 1)) * Vector3d(draw(0), draw(1), draw(2));
    for (Vector3d& v : b.vertices) v += by;
    b = make_mesh("moved", b.vertices, b.triangles);
    World world({.threads = 1});
    const auto add = [&](const Mesh& mesh) { return world.bodies().add({.model = world.models().add(Mesh(mesh))}); };
    const BodyId of_a = add(a), of_b = add(b);
    const oracle::ManifoldVerdict found =
        oracle::judge_manifold(surface_of(a), surface_of(b), world.pairs().manifold(of_a, of_b, {.measures = true}));
    ++tally.pairs;
    tally.met += found.contacts > 0, tally.whole += found.whole, tally.exact += found.exact;
    tally.special += !found.general, tally.contacts += found.contacts;
    tally.faults += !found.fault.empty(), tally.first.take(seed, found.fault);
}

} // namespace

ManifoldTally try_manifolds(std::uint64_t first, std::uint64_t count, int threads, const std::function<void()>& done)
{
    return sum_of_seeds<ManifoldTally>(first, count, threads, try_pair, done);
}

} // namespace oncollide::tools
