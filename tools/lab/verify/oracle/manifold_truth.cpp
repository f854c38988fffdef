#include "verify/oracle/manifold_truth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <type_traits>

#include <boost/multiprecision/cpp_int.hpp>
#include <fmt/format.h>

#include "truth/exact_point.hpp"

namespace oncollide::oracle {

namespace {

using Rational = boost::multiprecision::cpp_rational;

template <class N>
using Point = PointOf<N>;

struct Unsure {};     ///< rounding of long double may decide
struct NotGeneral {}; ///< a sign is 0

/// The sign of a value that errs by less than `error` in long double. Rational is exact.
template <class N>
int sign_of(const N& value, long double error)
{
    if constexpr (std::is_same_v<N, long double>) {
        if (std::abs(value) <= error) throw Unsure{};
        return value > 0 ? 1 : -1;
    } else {
        (void)error;
        return value.sign();
    }
}

/// The same for coordinates in general position.
template <class N>
int side_of(const N& value, long double error)
{
    const int sign = sign_of(value, error);
    if (sign == 0) throw NotGeneral{};
    return sign;
}

/// True if a length, given by its square, is larger than a bound.
template <class N>
bool exceeds(const N& length2, double bound, long double error)
{
    if constexpr (std::is_same_v<N, long double>)
        return sign_of(std::sqrt(std::max(length2, 0.0L)) - (long double)(bound), error) > 0;
    else
        return length2 > N(bound) * N(bound);
}

template <class N>
struct Face {
    std::array<Point<N>, 3> corners;
    Point<N> normal; ///< not unit
    N height;        ///< of the plane along it
};

template <class N>
std::vector<Face<N>> faces_of(const Surface& surface)
{
    std::vector<Face<N>> faces;
    for (const TrianglePoints& t : surface) {
        Face<N> f{{point_of<N>(t[0]), point_of<N>(t[1]), point_of<N>(t[2])}, {}, {}};
        f.normal = cross(f.corners[1] - f.corners[0], f.corners[2] - f.corners[0]);
        f.height = dot(f.normal, f.corners[0]);
        faces.push_back(f);
    }
    return faces;
}

/// The edge pq pierces a face at the fraction `at`; none: it does not.
template <class N>
std::optional<N> piercing(const Point<N>& p, const Point<N>& q, const Face<N>& f, long double scale)
{
    const N from = dot(f.normal, p) - f.height, to = dot(f.normal, q) - f.height;
    const long double error = 1e-16L * scale * scale * scale;
    if (side_of(from, error) == side_of(to, error)) return {};
    const auto turn = [&](int k) {
        const Point<N>&u = f.corners[k], &v = f.corners[(k + 1) % 3];
        return side_of(N(dot(q - p, cross(u - p, v - p))), error);
    };
    const int first = turn(0);
    if (turn(1) != first || turn(2) != first) return {};
    return N(from / (from - to));
}

/// The contacts of two surfaces, and the vertices of each inside the other.
template <class N>
struct Overlap {
    std::vector<Point<N>> contacts;   ///< ends of the common segments
    std::vector<Point<N>> of_a, of_b; ///< vertices inside the other
    Point<N> area{N(0), N(0), N(0)};  ///< twice the area vector of a's part inside b
    std::vector<Face<N>> a, b;
};

/// A vertex is inside if a line from it crosses the other surface an odd number of times.
template <class N>
bool inside(const Point<N>& p, const std::vector<Face<N>>& faces, long double scale)
{
    const Point<N> end = p + point_of<N>({1237.0 / 64, 2311.0 / 64, 4093.0 / 64});
    bool in = false;
    for (const Face<N>& f : faces) in ^= piercing(p, end, f, 64 * scale).has_value();
    return in;
}

template <class N>
Overlap<N> overlap_of(const Surface& a, const Surface& b, long double scale)
{
    Overlap<N> o;
    o.a = faces_of<N>(a), o.b = faces_of<N>(b);
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t k = 0; k < b.size(); ++k) {
            std::vector<Point<N>> ends;
            for (const auto& [edges, face] : {std::pair(&o.a[i], &o.b[k]), std::pair(&o.b[k], &o.a[i])})
                for (int e = 0; e < 3; ++e) {
                    const Point<N>&p = edges->corners[e], &q = edges->corners[(e + 1) % 3];
                    if (const auto at = piercing(p, q, *face, scale)) ends.push_back(p + *at * (q - p));
                }
            if (ends.size() != 2) continue;
            // Along n_a x n_b, b's inside is to the left as seen from outside of a.
            const N along = dot(ends[1] - ends[0], cross(o.a[i].normal, o.b[k].normal));
            const Point<N> turn = cross(ends[0], ends[1]);
            o.area = side_of(along, 1e-18L) > 0 ? o.area + turn : o.area - turn;
            o.contacts.insert(o.contacts.end(), ends.begin(), ends.end());
        }
    const auto add = [&](const Surface& own, const std::vector<Face<N>>& other, std::vector<Point<N>>& to) {
        std::vector<std::array<double, 3>> seen;
        for (const TrianglePoints& t : own)
            for (const Eigen::Vector3d& p : t) {
                if (std::ranges::find(seen, std::array{p.x(), p.y(), p.z()}) != seen.end()) continue;
                seen.push_back({p.x(), p.y(), p.z()});
                if (inside(point_of<N>(p), other, scale)) to.push_back(point_of<N>(p));
            }
    };
    add(a, o.b, o.of_a), add(b, o.a, o.of_b);
    return o;
}

/// How far the point moves along `way` until it leaves the solid, in lengths of `way`; the least of all crossings.
template <class N>
N exit_of(const Point<N>& p, const Point<N>& way, const std::vector<Face<N>>& faces, double scale)
{
    std::optional<N> least;
    for (const Face<N>& f : faces) {
        const N slope = dot(f.normal, way);
        if (slope <= 0) continue;
        const N at = (f.height - dot(f.normal, p)) / slope;
        if (at < 0 || (least && at >= *least)) continue;
        const Point<N> hit = p + at * way;
        bool in = true;
        for (int k = 0; k < 3 && in; ++k) {
            const Point<N>&u = f.corners[k], &v = f.corners[(k + 1) % 3];
            in = dot(f.normal, cross(v - u, hit - u)) >= -N(std::is_same_v<N, long double> ? 1e-16 * scale : 0);
        }
        if (in) least = at;
    }
    return least ? *least : N(0);
}

/// Squared distance of p from the hull of at most four points in rational arithmetic: the least of all triangles.
template <class N>
N hull_distance2(const Point<N>& p, const std::vector<Point<N>>& hull)
{
    N least = dot(p - hull[0], p - hull[0]);
    const auto take = [&](const N& d) {
        if (d < least) least = d;
    };
    const std::size_t count = hull.size();
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = 0; j < count; ++j) {
            const Point<N> way = hull[j] - hull[i], from = p - hull[i];
            take(dot(from, from));
            const N length2 = dot(way, way), at = dot(way, from);
            if (length2 > 0 && at > 0 && at < length2) {
                const Point<N> off = from - N(at / length2) * way;
                take(dot(off, off));
            }
        }
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = i + 1; j < count; ++j)
            for (std::size_t k = j + 1; k < count; ++k) {
                const Point<N> n = cross(hull[j] - hull[i], hull[k] - hull[i]);
                const N n2 = dot(n, n);
                if (n2 <= 0) continue;
                const auto side = [&](std::size_t u, std::size_t v) {
                    return dot(n, cross(hull[v] - hull[u], p - hull[u])) >= 0;
                };
                const N height = dot(n, p - hull[i]);
                if (side(i, j) && side(j, k) && side(k, i)) take(N(height * height / n2));
            }
    return least;
}

template <class N>
bool is_kept(const Point<N>& contact, const Manifold& m, long double scale)
{
    return std::ranges::any_of(m.regions, [&](const ManifoldRegion& r) {
        std::vector<Point<N>> hull;
        for (std::uint32_t i = r.first; i < r.first + r.count; ++i)
            hull.push_back(N(0.5) * (point_of<N>(m.points[i].point_a) + point_of<N>(m.points[i].point_b)));
        return !exceeds(hull_distance2(contact, hull), r.lost, 1e-17L * scale);
    });
}

template <class N>
std::string judge_region(const Overlap<N>& o, const ManifoldRegion& r, double scale)
{
    const Point<N> n = point_of<N>(r.normal);
    const N nn = dot(n, n);
    // Upper: of the parts inside, a's highest point and b's lowest.
    N high = dot(n, o.contacts.front()), low = high;
    for (const auto* points : {&o.contacts, &o.of_a})
        for (const Point<N>& p : *points) high = std::max(high, N(dot(n, p)));
    for (const auto* points : {&o.contacts, &o.of_b})
        for (const Point<N>& p : *points) low = std::min(low, N(dot(n, p)));
    if (sign_of(N(high - low - N(r.depth_upper) * nn), 1e-16L * scale) > 0)
        return "after depth_upper no plane separates them";
    // Lower: a point of a goes out of b along -n, one of b out of a along n.
    N deepest(0);
    for (const Point<N>& p : o.of_a) deepest = std::max(deepest, exit_of(p, N(-1) * n, o.b, scale));
    for (const Point<N>& p : o.of_b) deepest = std::max(deepest, exit_of(p, n, o.a, scale));
    if (r.depth_lower > 0 && sign_of(N(N(r.depth_lower) - deepest), 1e-16L * scale) > 0)
        return fmt::format("depth_lower of {} is too large", r.depth_lower);
    if (r.normal_error >= std::numbers::pi / 2) return {};
    const N area2 = dot(o.area, o.area), sine(std::sin(r.normal_error) * (1 + 0x1p-50));
    const Point<N> aside = cross(n, o.area);
    const N most = sine * sine * nn * area2;
    const long double length = std::sqrt(static_cast<long double>(area2));
    if (sign_of(dot(n, o.area), 1e-3L * length) <= 0 ||
        sign_of(N(dot(aside, aside) - most), 1e-3L * static_cast<long double>(most)) > 0)
        return "the exact normal is farther than normal_error";
    return {};
}

template <class N>
std::string judge(const Surface& a, const Surface& b, const Manifold& m, double scale, ManifoldVerdict& verdict)
{
    const Overlap<N> o = overlap_of<N>(a, b, scale);
    verdict.contacts = o.contacts.size();
    if (o.contacts.empty()) return {};
    if (m.regions.empty()) return "there are contacts, but no region";
    for (const Point<N>& p : o.contacts)
        if (!is_kept(p, m, scale)) return "a contact is farther than `lost` from all regions";
    const ManifoldRegion& r = m.regions.front();
    if (m.regions.size() != 1 || r.kind != RegionKind::crossing || r.normal_error >= std::numbers::pi) return {};
    verdict.whole = true;
    return judge_region(o, r, scale);
}

} // namespace

ManifoldVerdict judge_manifold(const Surface& a, const Surface& b, const Manifold& manifold)
{
    ManifoldVerdict verdict;
    double scale = 1;
    for (const Surface* s : {&a, &b})
        for (const TrianglePoints& t : *s)
            for (const Eigen::Vector3d& p : t) scale = std::max(scale, p.cwiseAbs().maxCoeff());
    try {
        verdict.fault = judge<long double>(a, b, manifold, scale, verdict);
        if (verdict.fault.empty()) return verdict;
    } catch (const Unsure&) { // too near for long double
    }
    verdict.exact = true, verdict.whole = false;
    try {
        verdict.fault = judge<Rational>(a, b, manifold, scale, verdict);
    } catch (const NotGeneral&) {
        verdict.general = false, verdict.fault.clear();
    }
    return verdict;
}

} // namespace oncollide::oracle
