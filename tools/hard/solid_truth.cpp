#include "solid_truth.hpp"

#include <map>
#include <random>
#include <vector>

#include <oncollide/narrowphase/exact_predicates.hpp>
#include <oncollide/narrowphase/into_a.hpp>

#include "exact_inside.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

/// Triangles of a body somewhere, each with its box.
struct PlacedBody {
    std::vector<TrianglePoints> triangles;
    std::vector<Eigen::AlignedBox3d> boxes;
    Eigen::AlignedBox3d box;

    template <class Place>
    PlacedBody(const Mesh& mesh, Place place)
    {
        for (const Triangle& t : mesh.triangles) {
            triangles.push_back({place(mesh.vertices[t[0]]), place(mesh.vertices[t[1]]), place(mesh.vertices[t[2]])});
            boxes.emplace_back();
            for (const Vector3d& p : triangles.back()) boxes.back().extend(p);
            box.extend(boxes.back());
        }
    }
};

TriangleContact most_contact(const PlacedBody& a, const PlacedBody& b)
{
    TriangleContact most = TriangleContact::separate;
    for (std::size_t i = 0; i < a.triangles.size(); ++i) {
        if (!a.boxes[i].intersects(b.box)) continue;
        for (std::size_t j = 0; j < b.triangles.size() && most != TriangleContact::crossing; ++j)
            if (a.boxes[i].intersects(b.boxes[j]))
                most = std::max(most, oracle::contact(a.triangles[i], b.triangles[j]));
    }
    return most;
}

bool holds(const PlacedBody& outer, const Vector3d& p)
{
    return outer.box.contains(p) && oracle::winding(outer.triangles, p).value_or(0) != 0;
}

bool holds_a_corner(const PlacedBody& outer, const PlacedBody& inner)
{
    for (const TrianglePoints& t : inner.triangles)
        for (const Vector3d& p : t)
            if (holds(outer, p)) return true;
    return false;
}

/// Of points spread over what both boxes cover, one is inside both. However thin an overlap of boxes is, so are these.
bool share_a_point(const PlacedBody& a, const PlacedBody& b)
{
    constexpr int count = 500;
    const Eigen::AlignedBox3d both = a.box.intersection(b.box);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> part;
    for (int k = 0; k < count; ++k) {
        const Vector3d at = k ? Vector3d(part(random), part(random), part(random)) : Vector3d::Constant(0.5);
        const Vector3d p = both.min() + (both.max() - both.min()).cwiseProduct(at);
        if (holds(a, p) && holds(b, p)) return true;
    }
    return false;
}

/// What both boxes cover is narrower than the library looks for.
bool narrow(const PlacedBody& a, const PlacedBody& b)
{
    const Eigen::AlignedBox3d all = a.box.merged(b.box);
    const Vector3d extent = a.box.intersection(b.box).sizes();
    const double far = std::max(all.min().cwiseAbs().maxCoeff(), all.max().cwiseAbs().maxCoeff());
    return extent.minCoeff() < std::max(0x1p-18 * extent.maxCoeff(), 0x1p-32 * far);
}

} // namespace

SolidTruth solid_truth_of(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b,
                          const Eigen::Isometry3d& pose_b, bool deep)
{
    if (deep) return {.contact = TriangleContact::crossing};
    const PlacedBody at_a(a, [](const Vector3d&v) { return v; }), at_b(b, IntoA(pose_a, pose_b));
    const TriangleContact contact = most_contact(at_a, at_b);
    if (contact == TriangleContact::crossing) return {.contact = contact};
    if (contact == TriangleContact::touching) {
        const bool overlap = has_inside(a) && has_inside(b) && share_a_point(at_a, at_b);
        return {.contact = overlap ? TriangleContact::crossing : contact, .vague = overlap && narrow(at_a, at_b)};
    }
    return {.enclosed = (has_inside(a) && holds_a_corner(at_a, at_b)) || (has_inside(b) && holds_a_corner(at_b, at_a))};
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
