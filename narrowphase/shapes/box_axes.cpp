#include <oncollide/narrowphase/shapes/box_axes.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace oncollide {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double parallel = 1e-8; ///< sine

/// An axis of least overlap.
struct Axis {
    double overlap = std::numeric_limits<double>::infinity();
    int i = -1, j = -1; ///< of A, of B; -1: none
};

bool has_face(const Vector3d& half, int axis)
{
    return half[(axis + 1) % 3] > 0 && half[(axis + 2) % 3] > 0;
}

/// The middle of the edge of a box along `axis` that reaches farthest in the direction d.
Vector3d edge_along(const Vector3d& half, const Vector3d& d, int axis)
{
    Vector3d p;
    for (int k = 0; k < 3; ++k) p[k] = k == axis ? 0 : d[k] < 0 ? -half[k] : half[k];
    return p;
}

} // namespace

LeastTranslation translation_of_boxes(const ConvexDifference& cores, double rounding, double cutoff)
{
    const Convex &a = cores.a(), &b = cores.b();
    const Matrix3d& r = cores.b_to_a().rotation;
    const Matrix3d abs = r.cwiseAbs();
    const Vector3d ha = 0.5 * (a.high - a.low), hb = 0.5 * (b.high - b.low);
    const Vector3d centre_a = 0.5 * (a.low + a.high);
    const Vector3d t = cores.b_to_a()(0.5 * (b.low + b.high)) - centre_a;
    const Vector3d u = r.transpose() * t; // in B's frame
    const double size = cores.size(), smaller = std::min(a.extent + a.radius, b.extent + b.radius);
    LeastTranslation found{};
    const double beyond = -cutoff - rounding;
    double least = std::numeric_limits<double>::infinity(); // lower bound of all overlaps
    Axis face, edge;
    const auto apart = [&](double overlap) {
        found.beyond = true, found.upper = overlap + rounding;
        return found;
    };
    const auto width = [&](const Vector3d& n) { // rounded up
        return ha.dot(n.cwiseAbs()) + hb.dot((r.transpose() * n).cwiseAbs()) - n.dot(t) + rounding;
    };
    // A face of B must be better by a margin, so that equal faces do not take turns.
    const Vector3d of_a = ha + abs * hb - t.cwiseAbs(), of_b = hb + abs.transpose() * ha - u.cwiseAbs();
    for (int i = 0; i < 3; ++i) {
        if (!has_face(ha, i)) continue;
        if (of_a[i] < beyond) return apart(of_a[i]);
        if (of_a[i] < face.overlap) face = {of_a[i], i, -1};
    }
    const double preferred = face.overlap - face_preference(face.overlap, smaller);
    least = face.overlap;
    for (int j = 0; j < 3; ++j) {
        if (!has_face(hb, j)) continue;
        if (of_b[j] < beyond) return apart(of_b[j]);
        if (of_b[j] < least || face.i < 0) {
            least = std::min(least, of_b[j]);
            if (face.i < 0 ? of_b[j] < face.overlap : of_b[j] < preferred) face = {of_b[j], -1, j};
        }
    }
    least -= rounding;
    for (int i = 0; i < 3; ++i) {
        if (!(ha[i] > 0)) continue;
        const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
        for (int j = 0; j < 3; ++j) {
            if (!(hb[j] > 0)) continue;
            const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            const double length2 = r(i1, j) * r(i1, j) + r(i2, j) * r(i2, j);
            if (length2 < parallel * parallel) {
                least -= 2 * std::sqrt(length2) * size;
                continue;
            }
            const double inverse = 1 / std::sqrt(length2);
            const double raw = ha[i1] * abs(i2, j) + ha[i2] * abs(i1, j) + hb[j1] * abs(i, j2) + hb[j2] * abs(i, j1) -
                               std::abs(t[i2] * r(i1, j) - t[i1] * r(i2, j));
            const double overlap = raw * inverse, doubt = 2 * rounding * inverse;
            if (overlap + doubt < -cutoff) return apart(overlap + doubt);
            least = std::min(least, overlap - doubt);
            if (overlap < edge.overlap) edge = {overlap, i, j};
        }
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
        const double c = d.dot(e), rest = 1 - c * c;
        const Vector3d way = q - p;
        const double s = std::clamp((way.dot(d) - c * way.dot(e)) / rest, -ha[edge.i], ha[edge.i]);
        const double v = std::clamp((c * way.dot(d) - way.dot(e)) / rest, -hb[edge.j], hb[edge.j]);
        found.on_a = centre_a + p + s * d, found.on_b = centre_a + q + v * e, found.has_points = true;
    } else if (face.i >= 0) {
        found.normal = Vector3d::Unit(face.i) * (t[face.i] < 0 ? -1 : 1);
        found.upper = face.overlap + rounding;
    } else if (face.j >= 0) {
        found.normal = r.col(face.j).normalized() * (u[face.j] < 0 ? -1 : 1);
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

} // namespace oncollide
