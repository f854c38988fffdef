#include <oncollide/narrowphase/exact/neighbours.hpp>

#include <algorithm>
#include <cmath>
#include <span>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/flat_triangles.hpp>

namespace oncollide {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// At most three positions, each once.
struct Positions {
    std::array<Vector3d, 3> at;
    std::size_t count = 0;

    void add(const Vector3d& p)
    {
        if (!has(p)) at[count++] = p;
    }
    bool has(const Vector3d& p) const { return std::find(begin(), end(), p) != end(); }
    const Vector3d* begin() const { return at.data(); }
    const Vector3d* end() const { return at.data() + count; }
};

/// The positions of the triangle's corners that are not among `without`.
Positions rest_of(const TrianglePoints& triangle, const Positions& without)
{
    Positions rest;
    for (const Vector3d& corner : triangle)
        if (!without.has(corner)) rest.add(corner);
    return rest;
}

/// Along a line, lexicographic order is the order of points.
bool ahead(const Vector3d& p, const Vector3d& q)
{
    return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
}

/// A part of a triangle as the hull of one of its corners and a segment that does not contain this corner.
struct Wedge {
    Vector3d from, to;
};

/// The triangle as wedges at its corner p: one, two if p is inside a segment, or none if the triangle is the point p.
std::span<const Wedge> wedges_at(const Vector3d& p, const TrianglePoints& triangle, std::array<Wedge, 2>& wedges)
{
    Positions without;
    without.add(p);
    const Positions rest = rest_of(triangle, without);
    if (rest.count == 0) return {};
    const Vector3d &x = rest.at[0], &y = rest.at[rest.count - 1];
    wedges[0] = {x, y};
    if (rest.count == 1 || !collinear(p, x, y)) return {wedges.data(), 1};
    if (ahead(p, x) != ahead(p, y)) {
        wedges = {Wedge{x, x}, Wedge{y, y}};
        return {wedges.data(), 2};
    }
    const Vector3d& farthest = ahead(p, x) == ahead(x, y) ? y : x;
    wedges[0] = {farthest, farthest};
    return {wedges.data(), 1};
}

/// True if triangles meet in more than their common corner p. If they do, a ray from p through such a point leaves one
/// of them where it is still in the other.
bool meet_beyond_corner(const Vector3d& p, const TrianglePoints& a, const TrianglePoints& b)
{
    std::array<Wedge, 2> of_a, of_b;
    for (const Wedge& x : wedges_at(p, a, of_a))
        for (const Wedge& y : wedges_at(p, b, of_b))
            if (triangles_meet({x.from, x.to, x.to}, {p, y.from, y.to}) ||
                triangles_meet({p, x.from, x.to}, {y.from, y.to, y.to}))
                return true;
    return false;
}

/// True if triangles meet in more than their common edge pq; r and s are their third corners.
bool meet_beyond_edge(const Vector3d& p, const Vector3d& q, const Vector3d& r, const Vector3d& s)
{
    for (int axis = 0; axis < 3; ++axis) {
        const Vector2d from = projected(p, axis), to = projected(q, axis);
        const int side = orient2d(from, to, projected(r, axis));
        if (side) return side == orient2d(from, to, projected(s, axis)) && orient3d(p, q, r, s) == 0;
    }
    // The first triangle is a segment, and meets the second in the edge unless that is a segment of the same line.
    if (!collinear(p, q, s)) return false;
    const bool up = ahead(p, q), r_past_q = ahead(q, r) == up, s_past_q = ahead(q, s) == up;
    const bool r_past_p = ahead(r, p) == up, s_past_p = ahead(s, p) == up;
    return (r_past_q && s_past_q) || (r_past_p && s_past_p);
}

/// True if `side` . `edge` > 0 is certain for the exact edge. The components of edges are differences rounded once, by
/// 2^-53 of themselves, and the sum rounds at most three times more; products below 2^-1000 may underflow.
bool certainly_ahead(const Vector3d& side, const Vector3d& edge)
{
    return side.dot(edge) > 0x1p-49 * side.cwiseAbs().dot(edge.cwiseAbs()) + 0x1p-1000;
}

} // namespace

bool meet_beyond_shared(const TrianglePoints& a, const TrianglePoints& b)
{
    Positions shared;
    for (const Vector3d& p : a)
        if (std::find(b.begin(), b.end(), p) != b.end()) shared.add(p);
    if (shared.count == 0) return triangles_meet(a, b);
    if (shared.count == 1) return meet_beyond_corner(shared.at[0], a, b);
    if (shared.count == 3) return !collinear(a[0], a[1], a[2]);
    const Positions of_a = rest_of(a, shared), of_b = rest_of(b, shared);
    return of_a.count && of_b.count && meet_beyond_edge(shared.at[0], shared.at[1], of_a.at[0], of_b.at[0]);
}

bool certainly_share_corner_only(const Vector3d& p, const Vector3d& a1, const Vector3d& a2, const Vector3d& b1,
                                 const Vector3d& b2)
{
    const Vector3d to_a1 = a1 - p, to_a2 = a2 - p, to_b1 = b1 - p, to_b2 = b2 - p;
    const Vector3d sum_a = to_a1 + to_a2, sum_b = to_b1 + to_b2;
    const Vector3d side = sum_a * sum_b.norm() - sum_b * sum_a.norm();
    return certainly_ahead(side, to_a1) && certainly_ahead(side, to_a2) && certainly_ahead(-side, to_b1) &&
           certainly_ahead(-side, to_b2);
}

bool certainly_share_edge_only(const Vector3d& p, const Vector3d& q, const Vector3d& r, const Vector3d& s)
{
    const Vector3d edge = q - p, to_r = r - p, to_s = s - p;
    // The product of the triangles' heights above the edge, as vectors, times the edge's squared length. If it is
    // negative, a plane through the edge has the triangles on its two sides. Differences are rounded once, by 2^-53 of
    // themselves, and each term passes through less than 16 more roundings.
    const double heights = to_r.dot(to_s) * edge.squaredNorm() - to_r.dot(edge) * to_s.dot(edge);
    const auto sum = [](const Vector3d& v) { return std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]); };
    const double length = sum(edge);
    if (heights < -(0x1p-48 * (sum(to_r) * sum(to_s)) * (length * length) + filter_tiny)) return true;
    return orient3d_filter(p, q, r, s) != 0;
}

} // namespace oncollide
