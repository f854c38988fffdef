#include "hard/solid_truth.hpp"

#include <map>
#include <random>
#include <vector>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/relative_pose.hpp>

#include "hard/body_truth.hpp"
#include "hard/exact_inside.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

/// A closed surface, transformed.
struct PlacedSolid {
    std::vector<TrianglePoints> triangles;
    BoxedTriangles::Box box;

    explicit PlacedSolid(const BoxedTriangles& of) : box(of.box())
    {
        for (std::uint32_t i = 0; i < of.mesh().triangles.size(); ++i) triangles.push_back(of.triangle(i));
    }
    bool holds(const Vector3d& p) const { return box.contains(p) && oracle::winding(triangles, p).value_or(0) != 0; }
};

bool holds_a_corner(const BoxedTriangles& outer, const BoxedTriangles& inner)
{
    if (!has_inside(outer.mesh())) return false;
    const PlacedSolid solid(outer);
    for (const Triangle& t : inner.mesh().triangles)
        for (std::uint32_t v : t)
            if (solid.holds(inner.points()[v])) return true;
    return false;
}

/// True if one of 500 points in the intersection of both AABBs is inside both. The points fill even a thin
/// intersection.
bool share_a_point(const PlacedSolid& a, const PlacedSolid& b)
{
    constexpr int count = 500;
    const BoxedTriangles::Box both = a.box.intersection(b.box);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> part;
    for (int k = 0; k < count; ++k) {
        const Vector3d at = k ? Vector3d(part(random), part(random), part(random)) : Vector3d::Constant(0.5);
        const Vector3d p = both.min() + (both.max() - both.min()).cwiseProduct(at);
        if (a.holds(p) && b.holds(p)) return true;
    }
    return false;
}

/// True if the intersection of both AABBs is thinner than the library searches.
bool narrow(const BoxedTriangles::Box& a, const BoxedTriangles::Box& b)
{
    const BoxedTriangles::Box all = a.merged(b);
    const Vector3d extent = a.intersection(b).sizes();
    const double far = std::max(all.min().cwiseAbs().maxCoeff(), all.max().cwiseAbs().maxCoeff());
    return extent.minCoeff() < std::max(0x1p-18 * extent.maxCoeff(), 0x1p-32 * far);
}

} // namespace

SolidTruth touching_truth_of(const BoxedTriangles& a, const BoxedTriangles& b)
{
    const bool overlap = has_inside(a.mesh()) && has_inside(b.mesh()) && share_a_point(PlacedSolid(a), PlacedSolid(b));
    return {.contact = overlap ? TriangleContact::crossing : TriangleContact::touching,
            .vague = overlap && narrow(a.box(), b.box())};
}

SolidTruth solid_truth_of(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b,
                          const Eigen::Isometry3d& pose_b, bool deep)
{
    if (deep) return {.contact = TriangleContact::crossing};
    const HalvedMesh halved_a(a), halved_b(b);
    const BoxedTriangles at_a(halved_a, [](const Vector3d&v) { return v; }),
        at_b(halved_b, RelativePose(pose_a, pose_b));
    const TriangleContact contact = contact_of(at_a, at_b, TriangleContact::crossing);
    if (contact == TriangleContact::crossing) return {.contact = contact};
    if (contact == TriangleContact::touching) return touching_truth_of(at_a, at_b);
    return {.enclosed = holds_a_corner(at_a, at_b) || holds_a_corner(at_b, at_a)};
}

bool has_inside(const Mesh& mesh)
{
    using Place = std::array<double, 3>;
    std::map<std::pair<Place, Place>, int> edges;
    for (const Triangle& t : mesh.triangles) {
        const Vector3d &p = mesh.vertices[t[0]], &q = mesh.vertices[t[1]], &r = mesh.vertices[t[2]];
        if (collinear(p, q, r)) continue;
        for (const auto& [from, to] : {std::pair(&p, &q), std::pair(&q, &r), std::pair(&r, &p)})
            ++edges[{Place{from->x(), from->y(), from->z()}, Place{to->x(), to->y(), to->z()}}];
    }
    for (const auto& [edge, count] : edges) {
        const auto back = edges.find({edge.second, edge.first});
        if (count != 1 || back == edges.end() || back->second != 1) return false;
    }
    return !edges.empty();
}

} // namespace oncollide::tools
