#include <oncollide/narrowphase/overlap/placed_faces.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// The crossings of a segment with a triangle: 1 from its front to its back, -1 from its back, 0 if there is none; none
/// if an end is on the triangle's plane within it, or an edge is touched.
std::optional<int> crossing_with(const Vector3d& from, const Vector3d& to, const std::array<Vector3d, 3>& t)
{
    const int at_from = orient3d(t[0], t[1], t[2], from), at_to = orient3d(t[0], t[1], t[2], to);
    if (at_from == at_to && at_from) return 0;
    int left = 0, right = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const int side = orient3d(from, to, t[k], t[(k + 1) % 3]);
        left += side > 0, right += side < 0;
    }
    if (left && right) return 0; // the segment's line passes beside the triangle
    if (left + right < 3 || !at_from || !at_to) return {};
    return (at_from - at_to) / 2;
}

} // namespace

PlacedFaces::PlacedFaces(const Mesh& mesh, const Eigen::Isometry3d& pose, const Vector3d& origin)
{
    std::vector<Vector3d> points(mesh.vertices.size());
    for (std::size_t v = 0; v < points.size(); ++v) points[v] = pose * mesh.vertices[v] - origin;
    std::vector<double> areas;
    for (const Triangle& t : mesh.triangles) {
        const std::array corners{points[t[0]], points[t[1]], points[t[2]]};
        if (collinear(corners[0], corners[1], corners[2])) continue;
        const Vector3d middle = (corners[0] + corners[1] + corners[2]) / 3;
        double radius2 = 0;
        for (const Vector3d& corner : corners) radius2 = std::max(radius2, (corner - middle).squaredNorm());
        faces_.push_back({corners, unit_normal(corners[0], corners[1], corners[2]), middle, std::sqrt(radius2)});
        areas.push_back((corners[1] - corners[0]).cross(corners[2] - corners[0]).squaredNorm());
        for (const Vector3d& corner : corners) bounds_.add(corner);
    }
    all_.resize(faces_.size());
    std::iota(all_.begin(), all_.end(), 0u);
    std::ranges::stable_sort(all_, std::greater<>(), [&](std::uint32_t face) { return areas[face]; });
    std::vector<Face> sorted;
    sorted.reserve(faces_.size());
    for (const std::uint32_t face : all_) sorted.push_back(faces_[face]);
    faces_ = std::move(sorted);
    std::iota(all_.begin(), all_.end(), 0u);
}

std::optional<int> PlacedFaces::winding(const Vector3d& point) const
{
    const double far = 2 * (bounds_.diagonal() + (point - bounds_.centre()).norm());
    for (std::uint64_t attempt = 0; attempt < 64; ++attempt) {
        Vector3d way;
        for (std::uint64_t k = 0; k < 3; ++k) way[int(k)] = u01(2, attempt, k) - 0.5;
        if (const auto change = winding_change(point + far * way.normalized(), point, all_)) return change;
    }
    return {};
}

std::optional<int> PlacedFaces::winding_change(const Vector3d& from, const Vector3d& to,
                                               std::span<const std::uint32_t> some) const
{
    int change = 0;
    for (const std::uint32_t face : some) {
        const auto crossed = crossing_with(from, to, faces_[face].corners);
        if (!crossed) return {};
        change += *crossed;
    }
    return change;
}

Vector3d way_to(const std::array<Vector3d, 3>& t, const Vector3d& point)
{
    // Regions of a triangle: Ericson, Real-Time Collision Detection, 5.1.5.
    const Vector3d ab = t[1] - t[0], ac = t[2] - t[0], ap = point - t[0];
    const double d1 = ab.dot(ap), d2 = ac.dot(ap);
    if (d1 <= 0 && d2 <= 0) return -ap;
    const Vector3d bp = point - t[1];
    const double d3 = ab.dot(bp), d4 = ac.dot(bp);
    if (d3 >= 0 && d4 <= d3) return -bp;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return d1 / (d1 - d3) * ab - ap;
    const Vector3d cp = point - t[2];
    const double d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d6 >= 0 && d5 <= d6) return -cp;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return d2 / (d2 - d6) * ac - ap;
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6) return (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (t[2] - t[1]) - bp;
    const double scale = 1 / (va + vb + vc);
    return vb * scale * ab + vc * scale * ac - ap;
}

} // namespace oncollide
