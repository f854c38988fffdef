#include <oncollide/narrowphase/exact/triangle_test.hpp>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/flat_triangles.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// u x v, and the same sum with magnitudes; see exact_predicates.hpp for the bound.
struct FilteredCross {
    Vector3d value, magnitude;

    FilteredCross(const Vector3d& u, const Vector3d& v)
    {
        for (int k = 0; k < 3; ++k) {
            const int i = (k + 1) % 3, j = (k + 2) % 3;
            const double left = u[i] * v[j], right = u[j] * v[i];
            value[k] = left - right, magnitude[k] = std::abs(left) + std::abs(right) + filter_tiny;
        }
    }

    /// The sign of (u x v) . w if certain, else 0.
    int side(const Vector3d& w) const
    {
        const double x = value.x() * w.x() + value.y() * w.y() + value.z() * w.z();
        const double bound = filter_bound_3d * (magnitude.x() * std::abs(w.x()) + magnitude.y() * std::abs(w.y()) +
                                                magnitude.z() * std::abs(w.z())) +
                             filter_tiny;
        return (x > bound) - (x < -bound);
    }
};

/// Sides of a plane on which the corners of a triangle are.
struct Sides {
    int of[3];

    Sides(const TrianglePoints& corners, const TrianglePoints& plane)
    {
        const FilteredCross normal(plane[1] - plane[0], plane[2] - plane[0]);
        for (int k = 0; k < 3; ++k) {
            of[k] = normal.side(corners[k] - plane[0]);
            if (!of[k]) of[k] = orient3d_exact(plane[0], plane[1], plane[2], corners[k]);
        }
    }
    bool apart() const { return of[0] && of[0] == of[1] && of[0] == of[2]; }
    bool in_plane() const { return !of[0] && !of[1] && !of[2]; }
    bool straddle() const
    {
        const bool above = of[0] > 0 || of[1] > 0 || of[2] > 0, below = of[0] < 0 || of[1] < 0 || of[2] < 0;
        return above && below;
    }
};

/// The corner that is alone on its side of the plane, the two others being on the other side or on the plane; or the
/// corner that is on the plane, both others being strictly on one side.
struct Lone {
    int corner;
    int side; ///< 1 or -1; for a corner on the plane, the side opposite to the others
};

Lone lone(const Sides& s)
{
    for (int k = 0; k < 3; ++k) {
        const int a = s.of[(k + 1) % 3], b = s.of[(k + 2) % 3];
        if (s.of[k] && a != s.of[k] && b != s.of[k]) return {k, s.of[k]};
        if (!s.of[k] && a && a == b) return {k, -a};
    }
    return {}; // not reached: the sides are neither all equal nor all 0
}

/// The sign of (q - p) x (t - s) . (s - p), which equals orient3d(p, q, t, s).
int side_of_edges(const Vector3d& p, const Vector3d& q, const Vector3d& s, const Vector3d& t)
{
    const int sign = FilteredCross(q - p, t - s).side(s - p);
    return sign ? sign : orient3d_exact(p, q, t, s);
}

} // namespace

TriangleContact triangle_contact(const TrianglePoints& a, const TrianglePoints& b)
{
    const Sides of_a(a, b);
    if (of_a.apart()) return TriangleContact::separate;
    const Sides of_b(b, a);
    if (of_b.apart()) return TriangleContact::separate;
    if (of_a.in_plane() || of_b.in_plane()) return flat_contact(a, b);

    // Each triangle cuts the line of the two planes in an interval, between the two edges that leave its lone corner.
    // The intervals meet if each begins before the other ends.
    const Lone la = lone(of_a), lb = lone(of_b);
    const Vector3d &p = a[la.corner], &s = b[lb.corner];
    const Vector3d &q = a[(la.corner + 1) % 3], &r = a[(la.corner + 2) % 3];
    const Vector3d &t = b[(lb.corner + 1) % 3], &u = b[(lb.corner + 2) % 3];
    const bool alike = la.side == lb.side;
    const int first = lb.side * side_of_edges(p, q, s, alike ? t : u);
    if (first < 0) return TriangleContact::separate;
    const int second = -lb.side * side_of_edges(p, r, s, alike ? u : t);
    if (second < 0) return TriangleContact::separate;
    const bool crossing = first && second && of_a.straddle() && of_b.straddle();
    return crossing ? TriangleContact::crossing : TriangleContact::touching;
}

bool triangles_meet(const TrianglePoints& a, const TrianglePoints& b)
{
    return triangle_contact(a, b) != TriangleContact::separate;
}

} // namespace oncollide
