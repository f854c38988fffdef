// Every end of the common segment, and every corner of an overlap in one plane, is a corner of one triangle in the
// other, an edge of one through the other, or the crossing of two edges in one plane. Exact tests decide which of these
// exist; only their coordinates are rounded.
#include <oncollide/narrowphase/exact/triangle_test.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/flat_triangles.hpp>

namespace oncollide {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Points common to both: at most 3 corners and 6 crossings of each.
struct Candidates {
    std::array<Vector3d, 18> point;
    int count = 0;
    int crossings = 0; ///< strictly through the inside of an edge and of a face: two of these are the ends

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

/// Sides of the plane of `face` on which the corners of `s` are; 0 if the face has no area.
std::array<int, 3> sides_of(const Simplex& face, const Simplex& s)
{
    std::array<int, 3> sides{};
    for (int i = 0; face.count == 3 && i < s.count; ++i)
        sides[i] = orient3d(face.corner[0], face.corner[1], face.corner[2], s.corner[i]);
    return sides;
}

/// Adds the points where edges of `thin` that are not in the plane of `face` meet it.
void add_piercing(const Simplex& face, const Simplex& thin, const std::array<int, 3>& sides, Candidates& out)
{
    const TrianglePoints& f = face.corner;
    for (int i = 0; i < edges(thin) && out.crossings < 2; ++i) {
        const int j = (i + 1) % thin.count;
        if (sides[i] == sides[j]) continue;
        const Vector3d &p = thin.corner[i], &q = thin.corner[j];
        const TriangleContact contact = pierce(f, p, q, sides[i], sides[j]);
        if (contact == TriangleContact::separate) continue;
        out.add(between(p, q, crossing_parameter(f[0], f[1], f[2], p, q)));
        out.crossings += contact == TriangleContact::crossing;
    }
}

/// Adds the corners of `s` that are in `t`, both in one plane.
void add_corners(const Simplex& s, const Simplex& t, int axis, Candidates& out)
{
    for (int i = 0; i < s.count; ++i)
        if (holds(t, s.corner[i], axis)) out.add(s.corner[i]);
}

/// Adds the points where edges of simplices in one plane cross strictly.
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

CommonSegment common_segment(const TrianglePoints& a, const TrianglePoints& b)
{
    const Simplex s = simplex_of(a), t = simplex_of(b);
    Candidates found;
    const std::array<int, 3> of_s = sides_of(t, s), of_t = sides_of(s, t), in_plane{};
    if (of_s == in_plane && of_t == in_plane) { // the triangles meet, so this includes two triangles without area
        const int axis = projection_axis(s, t);
        add_corners(s, t, axis, found), add_corners(t, s, axis, found);
        if (axis >= 0) add_crossings(s, t, axis, found);
    } else {
        add_piercing(s, t, of_t, found), add_piercing(t, s, of_s, found);
        if (s.count == 1 || t.count == 1) found.add(s.count == 1 ? s.corner[0] : t.corner[0]);
    }
    ONCOLLIDE_ASSERT(found.count > 0); // they meet
    // If an edge passes strictly through the inside of a face, the interiors meet next to the edge.
    return {farthest(found), found.crossings ? TriangleContact::crossing : triangle_contact(a, b)};
}

} // namespace oncollide
