#include <oncollide/narrowphase/shapes/box_axes.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/shapes/box_axes_kernel.hpp>

namespace oncollide {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double parallel = 1e-8; ///< sine

constexpr double unbounded_overlap = std::numeric_limits<double>::infinity();

OverlapBoxes* overlap_kernel()
{
    static OverlapBoxes* const kernel = ONCOLLIDE_CHOOSE_TO_AVX2(overlap_boxes);
    return kernel;
}

/// An axis of least overlap.
struct Axis {
    double overlap = unbounded_overlap;
    int i = -1, j = -1; ///< of A, of B; -1: none
};

/// The middle of the edge of a box along `axis` that reaches farthest in the direction d.
Vector3d edge_along(const Vector3d& half, const Vector3d& d, int axis)
{
    Vector3d p;
    for (int k = 0; k < 3; ++k) p[k] = k == axis ? 0 : d[k] < 0 ? -half[k] : half[k];
    return p;
}

} // namespace

BoxOverlap overlap_of_boxes(const Convex& a, const Convex& b, const RelativePose& b_to_a, double rounding)
{
    double ha[3], hb[3], t[3];
    for (int k = 0; k < 3; ++k) ha[k] = 0.5 * (a.high[k] - a.low[k]), hb[k] = 0.5 * (b.high[k] - b.low[k]);
    const Vector3d centre = b_to_a(0.5 * (b.low + b.high));
    for (int k = 0; k < 3; ++k) t[k] = centre[k] - 0.5 * (a.low[k] + a.high[k]);
    BoxOverlaps overlaps;
    overlap_kernel()({ha, hb, b_to_a.rotation.data(), t}, rounding, overlaps);
    const auto least_of = [](const double(&of)[4]) { return std::min(std::min(of[0], of[1]), of[2]); };
    const double of_faces = std::min(least_of(overlaps.of_a), least_of(overlaps.of_b));
    if (!(of_faces < unbounded_overlap)) return {-unbounded_overlap, unbounded_overlap}; // segments or points
    BoxOverlap found{of_faces - rounding, of_faces + rounding};
    for (unsigned open = overlaps.open; open; open &= open - 1) {
        const int bit = std::countr_zero(open), i = bit % 4, j = bit / 4;
        const double length2 = overlaps.length2[j][i];
        if (length2 < parallel * parallel) {
            found.lower -= 2 * std::sqrt(length2) * (a.extent + b.extent);
            continue;
        }
        const double inverse = 1 / std::sqrt(length2), doubt = 2 * rounding * inverse;
        const double overlap = overlaps.of_edges[j][i] * inverse;
        found = {std::min(found.lower, overlap - doubt), std::min(found.upper, overlap + doubt)};
    }
    return found;
}

LeastTranslation translation_of_boxes(const ConvexDifference& cores, double rounding, double cutoff)
{
    const Convex &a = cores.a(), &b = cores.b();
    const Matrix3d& r = cores.b_to_a().rotation;
    const Vector3d ha = 0.5 * (a.high - a.low), hb = 0.5 * (b.high - b.low);
    const Vector3d centre_a = 0.5 * (a.low + a.high);
    const Vector3d t = cores.b_to_a()(0.5 * (b.low + b.high)) - centre_a;
    const double size = cores.size(), smaller = std::min(a.extent + a.radius, b.extent + b.radius);
    BoxOverlaps overlaps;
    overlap_kernel()({ha.data(), hb.data(), r.data(), t.data()}, rounding, overlaps);
    const auto &of_a = overlaps.of_a, &of_b = overlaps.of_b;
    LeastTranslation found{};
    const auto apart = [&](double most) {
        found.beyond = true, found.upper = most + rounding;
        return found;
    };
    const auto width = [&](const Vector3d& n) { // rounded up
        return ha.dot(n.cwiseAbs()) + hb.dot((r.transpose() * n).cwiseAbs()) - n.dot(t) + rounding;
    };
    // A face of B must be better by a margin, so that equal faces do not take turns.
    const auto least_of = [](const double(&of)[4]) { // without branches, which would often be mispredicted
        int k = of[1] < of[0];
        k = of[2] < of[k] ? 2 : k;
        return k;
    };
    const int i_a = least_of(of_a), j_b = least_of(of_b);
    const bool any_a = of_a[i_a] < unbounded_overlap, any_b = of_b[j_b] < unbounded_overlap;
    const double preferred = any_a ? of_a[i_a] - face_preference(of_a[i_a], smaller) : unbounded_overlap;
    Axis face, edge;
    if (any_b && of_b[j_b] < preferred)
        face = {of_b[j_b], -1, j_b};
    else if (any_a)
        face = {of_a[i_a], i_a, -1};
    double least = std::min(of_a[i_a], of_b[j_b]); // lower bound of all overlaps
    if (least < -cutoff - rounding) return apart(least);
    least -= rounding;
    for (unsigned open = overlaps.open; open; open &= open - 1) {
        const int bit = std::countr_zero(open), i = bit % 4, j = bit / 4;
        if (!(ha[i] > 0) || !(hb[j] > 0)) continue;
        const double length2 = overlaps.length2[j][i];
        if (length2 < parallel * parallel) {
            least -= 2 * std::sqrt(length2) * size;
            continue;
        }
        const double inverse = 1 / std::sqrt(length2);
        const double most = overlaps.of_edges[j][i] * inverse, doubt = 2 * rounding * inverse;
        if (most + doubt < -cutoff) return apart(most + doubt);
        least = std::min(least, most - doubt);
        if (most < edge.overlap) edge = {most, i, j};
    }
    const bool of_edges = edge.overlap + face_preference(edge.overlap, smaller) < face.overlap;
    if (of_edges) {
        const Vector3d across = Vector3d::Unit(edge.i).cross(r.col(edge.j));
        const double length = across.norm();
        found.normal = across / (across.dot(t) < 0 ? -length : length);
        found.upper = width(found.normal);
        found.normal_error = std::min(std::numbers::pi, 0x1p-48 / length + 8 * cores.slack());
        // The nearest points of the two edges' lines.
        const Vector3d n = found.normal, p = edge_along(ha, n, edge.i), d = Vector3d::Unit(edge.i), e = r.col(edge.j);
        const Vector3d q = t + r * edge_along(hb, -(r.transpose() * n), edge.j);
        const double c = d.dot(e), rest = length * length; // 1 - c * c would be 0 for edges nearly parallel
        const Vector3d way = q - p;
        const double s = std::clamp((way.dot(d) - c * way.dot(e)) / rest, -ha[edge.i], ha[edge.i]);
        const double v = std::clamp((c * way.dot(d) - way.dot(e)) / rest, -hb[edge.j], hb[edge.j]);
        found.on_a = centre_a + p + s * d, found.on_b = centre_a + q + v * e, found.has_points = true;
    } else if (face.i >= 0) {
        found.normal = Vector3d::Unit(face.i) * (t[face.i] < 0 ? -1 : 1);
        found.upper = face.overlap + rounding;
    } else if (face.j >= 0) {
        found.normal = r.col(face.j).normalized() * (r.col(face.j).dot(t) < 0 ? -1 : 1);
        found.upper = face.overlap + rounding;
    } else { // points and parallel segments, which meet: they part across any of them
        const Vector3d line = ha.z() > 0 ? Vector3d(Vector3d::UnitZ()) : Vector3d(r.col(2));
        found.normal = line.unitOrthogonal();
        if (found.normal.dot(t) < 0) found.normal = -found.normal;
        found.upper = width(found.normal), least = -rounding;
    }
    if (!of_edges) found.normal_error = 0x1p-48 + 8 * cores.slack();
    found.lower = std::min(least, found.upper), found.of_axes = true;
    return found;
}

bool nearest_of_point_and_box(const ConvexDifference& cores, Vector3d& on_a, Vector3d& on_b, Vector3d& toward)
{
    const Convex &a = cores.a(), &b = cores.b();
    const RelativePose& into = cores.b_to_a();
    if (a.core != Convex::Core::box || b.core != Convex::Core::box) return false;
    if (b.low == b.high) {
        on_b = into(b.low), on_a = on_b.cwiseMax(a.low).cwiseMin(a.high), toward = on_b - on_a;
    } else if (a.low == a.high) {
        on_a = a.low;
        const Vector3d at = cores.into_b(on_a - into.translation), nearest = at.cwiseMax(b.low).cwiseMin(b.high);
        on_b = into(nearest), toward = into.rotation * (nearest - at);
    } else {
        return false;
    }
    return true;
}

} // namespace oncollide
