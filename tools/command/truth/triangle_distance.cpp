#include "truth/triangle_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace oncollide::tools {
namespace {

using Real = long double;

Real unit_part(Real value)
{
    return std::isfinite(value) ? std::clamp<Real>(value, 0, 1) : 0;
}

Vector3l normal_of(const TriangleL& t)
{
    return (t[1] - t[0]).cross(t[2] - t[0]);
}

/// A point of the triangle near p: exact if p's projection lies well inside, otherwise some point of the triangle.
Vector3l foot(const TriangleL& t, const Vector3l& p)
{
    const Vector3l n = normal_of(t);
    const Real area = n.squaredNorm();
    const Real v = unit_part((p - t[0]).cross(t[2] - t[0]).dot(n) / area);
    const Real w = std::min(unit_part((t[1] - t[0]).cross(p - t[0]).dot(n) / area), 1 - v);
    return t[0] + v * (t[1] - t[0]) + w * (t[2] - t[0]);
}

/// The point of a segment nearest to p.
Vector3l foot(const Vector3l& a, const Vector3l& b, const Vector3l& p)
{
    const Vector3l edge = b - a;
    return a + unit_part(edge.dot(p - a) / edge.squaredNorm()) * edge;
}

/// The nearest two points found so far.
struct Nearest {
    Real squared = std::numeric_limits<Real>::infinity();
    Vector3l gap = Vector3l::Zero();
    void take(const Vector3l& p, const Vector3l& q)
    {
        const Vector3l d = q - p;
        if (d.squaredNorm() < squared) squared = d.squaredNorm(), gap = d;
    }
};

void take_edges(const TriangleL& a, const TriangleL& b, Nearest& nearest)
{
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            const Vector3l &p = a[i], &q = b[j], &p_end = a[(i + 1) % 3], &q_end = b[(j + 1) % 3];
            nearest.take(p, foot(q, q_end, p)), nearest.take(foot(p, p_end, q), q);
            const Vector3l u = p_end - p, v = q_end - q, across = u.cross(v);
            // The nearest points of the lines; then each point is computed again from the other, which reduces
            // rounding.
            Vector3l on_p = p + unit_part((q - p).cross(v).dot(across) / across.squaredNorm()) * u;
            const Vector3l on_q = foot(q, q_end, on_p);
            on_p = foot(p, p_end, on_q);
            nearest.take(on_p, on_q);
        }
}

/// Vertices of `of` over the face of t, and points where its edges pierce t. `swapped`: points of t come first.
void take_face(const TriangleL& t, const TriangleL& of, bool swapped, Nearest& nearest)
{
    const Vector3l n = normal_of(t);
    if (n.isZero(0)) return;
    const auto take = [&](const Vector3l& p) {
        const Vector3l q = foot(t, p);
        swapped ? nearest.take(p, q) : nearest.take(q, p);
    };
    for (std::size_t k = 0; k < 3; ++k) {
        const Vector3l &p = of[k], &q = of[(k + 1) % 3];
        take(p);
        const Real over_p = n.dot(p - t[0]), over_q = n.dot(q - t[0]);
        if ((over_p < 0) != (over_q < 0)) take(p + unit_part(over_p / (over_p - over_q)) * (q - p));
    }
}

} // namespace

DistanceRange triangle_distance(const TriangleL& a, const TriangleL& b)
{
    Nearest nearest;
    take_edges(a, b, nearest), take_face(a, b, false, nearest), take_face(b, a, true, nearest);
    Real low = std::max(parted(a, b, normal_of(a)), parted(a, b, normal_of(b)));
    low = std::max(low, parted(a, b, nearest.gap));
    const Real high = std::sqrt(nearest.squared);
    // The direction of a gap near rounding is inaccurate; the direction across two edges is accurate.
    for (std::size_t i = 0; i < 3 && low < (1 - 1e-9L) * high; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            low = std::max(low, parted(a, b, (a[(i + 1) % 3] - a[i]).cross(b[(j + 1) % 3] - b[j])));
    return {std::min(low, high), high};
}

} // namespace oncollide::tools
