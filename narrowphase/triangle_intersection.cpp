// Every end of the common segment, and every corner of an overlap in one plane, is a corner of one triangle in the
// other, an edge of one through the other, or the crossing of two edges in one plane. Which of these exist is decided
// exactly; only their coordinates are rounded.
#include <oncollide/narrowphase/triangle_test.hpp>

#include <oncollide/narrowphase/exact_predicates.hpp>
#include <oncollide/narrowphase/flat_triangles.hpp>
#include <oncollide/scenes/error.hpp>

namespace oncollide {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Points common to both, at most 3 corners and 6 crossings of each.
struct Candidates {
    std::array<Vector3d, 18> point;
    int count = 0;

    void add(const Vector3d& p) { point[count++] = p; }
};

/// p + t (q - p). Each coordinate errs by at most 2^-48 times the larger of the two, t by 2^-49 t. Never overflows.
Vector3d between(const Vector3d& p, const Vector3d& q, double t)
{
    return (1 - t) * p + t * q;
}

int edges(const Simplex& s)
{
    return s.count == 3 ? 3 : s.count - 1;
}

/// Where edges of `thin` that are not in the plane of `face` meet it.
void add_piercing(const Simplex& face, const Simplex& thin, Candidates& out)
{
    if (face.count != 3) return;
    const TrianglePoints& f = face.corner;
    for (int i = 0; i < edges(thin); ++i) {
        const Vector3d &p = thin.corner[i], &q = thin.corner[(i + 1) % thin.count];
        if (pierce(f, p, q) != TriangleContact::separate)
            out.add(between(p, q, crossing_parameter(f[0], f[1], f[2], p, q)));
    }
}

/// Corners of `s` in `t`, both in one plane.
void add_corners(const Simplex& s, const Simplex& t, int axis, Candidates& out)
{
    for (int i = 0; i < s.count; ++i)
        if (holds(t, s.corner[i], axis)) out.add(s.corner[i]);
}

/// Where edges of simplices in one plane cross strictly.
void add_crossings(const Simplex& s, const Simplex& t, int axis, Candidates& out)
{
    for (int i = 0; i < edges(s); ++i)
        for (int j = 0; j < edges(t); ++j) {
            const Vector3d &p = s.corner[i], &q = s.corner[(i + 1) % s.count];
            const Vector2d a = projected(p, axis), b = projected(q, axis), c = projected(t.corner[j], axis),
                           d = projected(t.corner[(j + 1) % t.count], axis);
            if (orient2d(a, b, c) * orient2d(a, b, d) < 0 && orient2d(c, d, a) * orient2d(c, d, b) < 0)
                out.add(between(p, q, crossing_parameter(c, d, a, b)));
        }
}

bool in_one_plane(const Simplex& s, const Simplex& t)
{
    if (s.count < t.count) return in_one_plane(t, s);
    if (s.count < 3) return true; // they meet
    for (int i = 0; i < t.count; ++i)
        if (orient3d(s.corner[0], s.corner[1], s.corner[2], t.corner[i])) return false;
    return true;
}

std::array<Vector3d, 2> farthest(const Candidates& c)
{
    std::array<Vector3d, 2> best{c.point[0], c.point[0]};
    double length = 0;
    for (int i = 0; i < c.count; ++i)
        for (int j = i + 1; j < c.count; ++j)
            if (const double d = (c.point[i] - c.point[j]).stableNorm(); d > length)
                length = d, best = {c.point[i], c.point[j]};
    return best;
}

} // namespace

TriangleIntersection intersection(const TrianglePoints& a, const TrianglePoints& b)
{
    const Simplex s = simplex_of(a), t = simplex_of(b);
    Candidates found;
    if (in_one_plane(s, t)) {
        const int axis = projection_axis(s, t);
        add_corners(s, t, axis, found), add_corners(t, s, axis, found);
        if (axis >= 0) add_crossings(s, t, axis, found);
    } else {
        add_piercing(s, t, found), add_piercing(t, s, found);
        if (s.count == 1 || t.count == 1) found.add(s.count == 1 ? s.corner[0] : t.corner[0]);
    }
    ONCOLLIDE_ASSERT(found.count > 0); // they meet
    return {farthest(found), unit_normal(a[0], a[1], a[2]), unit_normal(b[0], b[1], b[2])};
}

} // namespace oncollide
