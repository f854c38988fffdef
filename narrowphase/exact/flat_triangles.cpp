#include <oncollide/narrowphase/exact/flat_triangles.hpp>

#include <algorithm>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>

namespace oncollide {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Along a line, lexicographic order is the order of points.
bool before(const Vector3d& p, const Vector3d& q)
{
    return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
}

/// An axis along which the triangle's projection has area; -1 if the triangle has none.
int axis_of(const Vector3d& a, const Vector3d& b, const Vector3d& c)
{
    for (int axis = 0; axis < 3; ++axis)
        if (orient2d(projected(a, axis), projected(b, axis), projected(c, axis))) return axis;
    return -1;
}

/// True if an edge of `a` has all of `b` strictly on its outer side; both are projected along `axis`.
bool edge_parts(const Simplex& a, const Simplex& b, int axis)
{
    const auto side = [&](int i, int j, const Vector3d& p) {
        return orient2d(projected(a.corner[i], axis), projected(a.corner[j], axis), projected(p, axis));
    };
    for (int i = 0; i < (a.count == 3 ? 3 : a.count - 1); ++i) {
        const int j = (i + 1) % a.count;
        const int outer = a.count == 3 ? -side(i, j, a.corner[(i + 2) % 3]) : side(i, j, b.corner[0]);
        if (outer && std::all_of(b.corner.begin(), b.corner.begin() + b.count,
                                 [&](const Vector3d& p) { return side(i, j, p) == outer; }))
            return true;
    }
    return false;
}

/// True if simplices in one plane meet. Two disjoint convex figures in a plane are separated by a line along an edge of
/// one of them, unless all corners are on one line.
bool coplanar_meet(const Simplex& a, const Simplex& b)
{
    const int axis = projection_axis(a, b);
    if (axis < 0) {
        const Vector3d &a_last = a.corner[a.count - 1], &b_last = b.corner[b.count - 1];
        return !before(a_last, b.corner[0]) && !before(b_last, a.corner[0]);
    }
    return !edge_parts(a, b, axis) && !edge_parts(b, a, axis);
}

TriangleContact touching_if(bool meet)
{
    return meet ? TriangleContact::touching : TriangleContact::separate;
}

/// A triangle with area against a point or a segment.
TriangleContact against_face(const Simplex& face, const Simplex& thin)
{
    const TrianglePoints& f = face.corner;
    const Vector3d &p = thin.corner[0], &q = thin.corner[thin.count - 1];
    const int of_p = orient3d(f[0], f[1], f[2], p), of_q = orient3d(f[0], f[1], f[2], q);
    if (of_p && of_p == of_q) return TriangleContact::separate;
    return of_p || of_q ? pierce(f, p, q, of_p, of_q) : touching_if(coplanar_meet(face, thin));
}

} // namespace

Simplex simplex_of(const TrianglePoints& t)
{
    if (!collinear(t[0], t[1], t[2])) return {3, t};
    const auto [low, high] = std::minmax_element(t.begin(), t.end(), before);
    return *low == *high ? Simplex{1, {*low}} : Simplex{2, {*low, *high}};
}

int projection_axis(const Simplex& a, const Simplex& b)
{
    if (a.count == 3) return axis_of(a.corner[0], a.corner[1], a.corner[2]);
    if (b.count == 3) return axis_of(b.corner[0], b.corner[1], b.corner[2]);
    for (const auto& [s, t] : {std::pair(&a, &b), std::pair(&b, &a)})
        for (int k = 0; k < t->count; ++k)
            if (const int axis = axis_of(s->corner[0], s->corner[s->count - 1], t->corner[k]); axis >= 0) return axis;
    return -1;
}

bool holds(const Simplex& s, const Vector3d& p, int axis)
{
    if (s.count == 1) return s.corner[0] == p;
    const auto side = [&](int i, int j) {
        return orient2d(projected(s.corner[i], axis), projected(s.corner[j], axis), projected(p, axis));
    };
    if (s.count == 2) return (axis < 0 || side(0, 1) == 0) && !before(p, s.corner[0]) && !before(s.corner[1], p);
    const int x = side(0, 1), y = side(1, 2), z = side(2, 0);
    return std::min({x, y, z}) >= 0 || std::max({x, y, z}) <= 0;
}

TriangleContact pierce(const TrianglePoints& f, const Vector3d& p, const Vector3d& q, int of_p, int of_q)
{
    const int x = orient3d(p, q, f[0], f[1]), y = orient3d(p, q, f[1], f[2]), z = orient3d(p, q, f[2], f[0]);
    const int low = std::min({x, y, z}), high = std::max({x, y, z});
    if (low < 0 && high > 0) return TriangleContact::separate;
    return of_p && of_q && low == high ? TriangleContact::crossing : TriangleContact::touching;
}

TriangleContact flat_contact(const TrianglePoints& a, const TrianglePoints& b)
{
    const Simplex s = simplex_of(a), t = simplex_of(b);
    if (s.count == 3 && t.count == 3) return touching_if(coplanar_meet(s, t));
    if (s.count == 3) return against_face(s, t);
    if (t.count == 3) return against_face(t, s);
    const bool coplanar =
        s.count == 1 || t.count == 1 || orient3d(s.corner[0], s.corner[1], t.corner[0], t.corner[1]) == 0;
    return touching_if(coplanar && coplanar_meet(s, t));
}

} // namespace oncollide
