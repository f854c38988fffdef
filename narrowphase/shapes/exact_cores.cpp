#include <oncollide/narrowphase/shapes/exact_cores.hpp>

#include <algorithm>
#include <cmath>
#include <set>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/narrowphase/exact/wide_vector.hpp>
#include <oncollide/scenes/model/box_corners.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

using PointList = std::vector<Vector3d>;
using Edge = std::array<std::uint32_t, 2>;

/// A core as its corners and faces; faces without area represent a point or a segment.
struct Polytope {
    PointList points;
    std::vector<Triangle> faces;

    explicit Polytope(const Convex& c)
    {
        if (c.core == Convex::Core::points) {
            points.assign(c.points, c.points + c.count), faces.assign(c.faces.begin(), c.faces.end());
        } else if ((c.low.array() < c.high.array()).all()) {
            for (unsigned k = 0; k < 8; ++k) points.push_back(corner_of({c.low, c.high}, k));
            faces.assign(box_faces.begin(), box_faces.end());
        } else {
            points = {c.low, c.high}, faces = {{0, 1, 1}};
        }
    }
    bool has_volume() const { return faces.size() > 3; }
};

Aabb box_of(const PointList& points)
{
    Aabb box;
    for (const Vector3d& p : points) box.add(p);
    return box;
}

std::vector<double> numbers_of(const PointList& a, const PointList& b)
{
    std::vector<double> numbers;
    for (const PointList* points : {&a, &b})
        for (const Vector3d& p : *points) numbers.insert(numbers.end(), p.data(), p.data() + 3);
    return numbers;
}

TrianglePoints corners_of(const PointList& points, const Triangle& t)
{
    return {points[t[0]], points[t[1]], points[t[2]]};
}

/// The triangles whose bounds overlap the box.
std::vector<TrianglePoints> triangles_in(const Aabb& box, const PointList& points,
                                         const std::vector<Triangle>& triangles)
{
    std::vector<TrianglePoints> found;
    for (const Triangle& t : triangles) {
        const TrianglePoints c = corners_of(points, t);
        const Vector3d low = c[0].cwiseMin(c[1]).cwiseMin(c[2]), high = c[0].cwiseMax(c[1]).cwiseMax(c[2]);
        if ((low.array() <= box.max.array()).all() && (high.array() >= box.min.array()).all()) found.push_back(c);
    }
    return found;
}

bool holds(const PointList& points, const std::vector<Triangle>& faces, const Vector3d& p)
{
    return std::ranges::none_of(
        faces, [&](const Triangle& f) { return orient3d(points[f[0]], points[f[1]], points[f[2]], p) > 0; });
}

/// The vertices, edges and faces of a core.
struct Features {
    PointList points;
    std::vector<std::uint32_t> vertices;
    std::vector<Edge> edges;
    std::vector<Triangle> faces;

    explicit Features(const Polytope& core) : points(core.points)
    {
        std::set<std::uint32_t> used;
        std::set<Edge> joined;
        for (const Triangle& t : core.faces) {
            used.insert(t.begin(), t.end());
            for (std::size_t k = 0; k < 3; ++k)
                if (const auto [i, j] = std::minmax(t[k], t[(k + 1) % 3]); i != j) joined.insert({i, j});
            if (t[0] != t[1] && t[1] != t[2]) faces.push_back(t);
        }
        vertices.assign(used.begin(), used.end()), edges.assign(joined.begin(), joined.end());
    }
};

/// Compares distances of features with a radius, in integers of N limbs. Each test compares only the planes and lines
/// of two features, and counts if the nearest points are inside both.
template <int N>
class Within {
public:
    using Vector = WideVector<N, 3>;

    Within(const BinaryGrid& grid, double radius_a, double radius_b)
        : grid_(grid), radius_(on_grid<N>(radius_a, grid) + on_grid<N>(radius_b, grid)), radius2_(radius_ * radius_)
    {
    }

    bool points(const Vector3d& p, const Vector3d& q) const
    {
        const Vector w = from_to(p, q);
        return not_above(along(w, w), radius2_);
    }
    bool edge(const Vector3d& p, const Vector3d& from, const Vector3d& to) const
    {
        const Vector e = from_to(from, to), w = from_to(from, p);
        const WideInteger<2 *N> t = along(w, e), ee = along(e, e);
        if (ee.sign() == 0 || t.sign() < 0 || !not_above(t, ee)) return false;
        return not_above(along(w, w) * ee - t * t, radius2_ * ee);
    }
    bool edges(const Vector3d& p, const Vector3d& p2, const Vector3d& q, const Vector3d& q2) const
    {
        const Vector e = from_to(p, p2), f = from_to(q, q2), w = from_to(p, q);
        const auto n = cross<N>(e, f);
        const WideInteger<4 * N> nn = along(n, n);
        if (nn.sign() == 0) return false; // parallel: other features at their ends decide
        for (const Vector& other : {f, e}) {
            const WideInteger<4 * N> s = along(cross<N>(w, other), n);
            if (s.sign() < 0 || !not_above(s, nn)) return false;
        }
        return plane(w, n, nn);
    }
    bool face(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) const
    {
        const auto n = cross<N>(from_to(a, b), from_to(a, c));
        for (const auto& [from, to] : {std::pair(&a, &b), std::pair(&b, &c), std::pair(&c, &a)})
            if (along(cross<N>(from_to(*from, *to), from_to(*from, p)), n).sign() < 0) return false;
        return plane(from_to(a, p), n, along(n, n));
    }

private:
    Vector from_to(const Vector3d& p, const Vector3d& q) const { return difference<N, 3>(grid_, q, p); }
    template <int M>
    static WideInteger<2 * M> along(const WideVector<M, 3>& u, const WideVector<M, 3>& v)
    {
        return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    }
    template <int M>
    static bool not_above(const WideInteger<M>& x, const WideInteger<M>& y)
    {
        return (y - x).sign() >= 0;
    }
    bool plane(const Vector& w, const WideVector<2 * N, 3>& n, const WideInteger<4 * N>& nn) const
    {
        if (nn.sign() == 0) return false; // no area
        const WideInteger<3 * N> height = dot(n, w);
        return not_above(height * height, radius2_ * nn);
    }

    const BinaryGrid grid_;
    const WideInteger<N> radius_;
    const WideInteger<2 * N> radius2_;
};

template <int N>
bool any_within(const Within<N>& within, const Features& a, const Features& b)
{
    const auto with = [&](const Features& x, const Features& y) { // vertices of x against the edges and faces of y
        return std::ranges::any_of(x.vertices, [&](std::uint32_t v) {
            const Vector3d& p = x.points[v];
            const auto near_edge = [&](const Edge& e) { return within.edge(p, y.points[e[0]], y.points[e[1]]); };
            const auto near_face = [&](const Triangle& f) {
                return within.face(p, y.points[f[0]], y.points[f[1]], y.points[f[2]]);
            };
            return std::ranges::any_of(y.edges, near_edge) || std::ranges::any_of(y.faces, near_face);
        });
    };
    for (std::uint32_t v : a.vertices)
        for (std::uint32_t w : b.vertices)
            if (within.points(a.points[v], b.points[w])) return true;
    if (with(a, b) || with(b, a)) return true;
    for (const Edge& e : a.edges)
        for (const Edge& f : b.edges)
            if (within.edges(a.points[e[0]], a.points[e[1]], b.points[f[0]], b.points[f[1]])) return true;
    return false;
}

bool cores_meet(const Polytope& a, const Polytope& b)
{
    const auto of_a = triangles_in(box_of(b.points), a.points, a.faces);
    const auto of_b = triangles_in(box_of(a.points), b.points, b.faces);
    for (const TrianglePoints& t : of_a)
        for (const TrianglePoints& u : of_b)
            if (triangles_meet(t, u)) return true;
    // Their surfaces are apart: one is completely inside the other, or both are outside.
    return (a.has_volume() && holds(a.points, a.faces, b.points[b.faces[0][0]])) ||
           (b.has_volume() && holds(b.points, b.faces, a.points[a.faces[0][0]]));
}

} // namespace

double exact_gap(const Convex& a, const Convex& b, const RelativePose& b_to_a)
{
    Polytope of_a(a), of_b(b);
    for (Vector3d& p : of_b.points) p = b_to_a(p);
    if (cores_meet(of_a, of_b)) return 0;
    std::vector<double> numbers = numbers_of(of_a.points, of_b.points);
    numbers.insert(numbers.end(), {a.radius, b.radius});
    const BinaryGrid grid = grid_of(numbers);
    // Some determinant of three differences is at least 1 on the grid; its length is below 2^(2 bits + 4).
    if (a.radius == 0 && b.radius == 0) return std::ldexp(1.0, grid.exponent - 2 * grid.bits - 4);
    const bool met = with_limbs(grid, [&](auto limbs) {
        return any_within(Within<decltype(limbs)::value>(grid, a.radius, b.radius), Features(of_a), Features(of_b));
    });
    // The squares of distance and radius differ by at least 1 over a square below 2^(4 bits + 8); distance and radius
    // are below 2^(bits + 3).
    return met ? 0 : std::ldexp(1.0, grid.exponent - 5 * grid.bits - 12);
}

} // namespace oncollide
