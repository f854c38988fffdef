#include "verify/oracle/solid_gap.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace oncollide::oracle {
namespace {

using Real = long double;

/// Up to four points, and the point of their hull that is nearest to the origin.
struct GapSimplex {
    std::array<LongVector, 4> points;
    int count = 0;
    LongVector toward_origin; ///< unit: away from the nearest point
    Real distance = -1;       ///< of the nearest point; -1: none yet

    bool has(const LongVector& p) const
    {
        return std::any_of(points.begin(), points.begin() + count, [&](const LongVector& q) { return q == p; });
    }
    /// Reduces the simplex to the face that holds the nearest point. The newest point is in it.
    /// False: the distance did not shrink. `distance` is 0 if the simplex contains the origin.
    bool add(const LongVector& newest);
};

struct NearestFace {
    Real distance = std::numeric_limits<Real>::infinity();
    LongVector toward = LongVector::Zero();
    std::array<int, 3> corners{};
    int count = 0;

    void take(const LongVector& nearest, std::initializer_list<int> of)
    {
        const Real length = nearest.norm();
        if (length < distance) set(length, length > 0 ? LongVector(-nearest / length) : LongVector::Zero(), of);
    }
    void set(Real length, const LongVector& way, std::initializer_list<int> of)
    {
        distance = length, toward = way, count = int(of.size());
        std::copy(of.begin(), of.end(), corners.begin());
    }
};

bool GapSimplex::add(const LongVector& newest)
{
    points[count] = newest;
    const int last = count;
    const auto& p = points;
    if (count == 3) {
        // Inside: the origin is on the same side of each face as the fourth point.
        const auto volume = [](const LongVector& u, const LongVector& v, const LongVector& w) {
            return u.dot(v.cross(w));
        };
        const Real whole = volume(p[1] - p[0], p[2] - p[0], p[3] - p[0]);
        const Real of0 = volume(p[1], p[2], p[3]), of1 = -volume(p[0], p[2], p[3]), of2 = volume(p[0], p[1], p[3]),
                   of3 = -volume(p[0], p[1], p[2]);
        const auto agrees = [&](Real part) { return whole > 0 ? part >= 0 : part <= 0; };
        if (whole != 0 && agrees(of0) && agrees(of1) && agrees(of2) && agrees(of3)) {
            count = 4, distance = 0;
            return true;
        }
    }
    NearestFace best;
    best.take(newest, {last});
    for (int i = 0; i < last; ++i) {
        const LongVector edge = p[i] - newest;
        const Real length2 = edge.squaredNorm(), along = -newest.dot(edge);
        if (along > 0 && along < length2) best.take(newest + along / length2 * edge, {i, last});
    }
    for (int i = 0; i < last; ++i)
        for (int k = i + 1; k < last; ++k) {
            const LongVector n = (p[i] - newest).cross(p[k] - newest);
            const Real length2 = n.squaredNorm(), of_k = n.dot(newest.cross(p[i])), of_newest = n.dot(p[i].cross(p[k])),
                       of_i = n.dot(p[k].cross(newest));
            if (length2 == 0 || of_k < 0 || of_newest < 0 || of_i < 0) continue;
            // A point of the triangle, even where the triangle is a sliver; but the way is across the triangle.
            const LongVector at = (of_i * p[i] + of_k * p[k] + of_newest * newest) / (of_i + of_k + of_newest);
            if (const Real length = at.norm(); length < best.distance)
                best.set(length, LongVector(n * ((n.dot(newest) > 0 ? -1 : 1) / std::sqrt(length2))), {i, k, last});
        }
    if (distance >= 0 && best.distance >= distance) return false;
    std::array<LongVector, 3> kept;
    for (int k = 0; k < best.count; ++k) kept[k] = p[best.corners[k]];
    std::copy_n(kept.begin(), best.count, points.begin());
    count = best.count, distance = best.distance, toward_origin = best.toward;
    return true;
}

/// Narrows the bounds of the cores' distance, from a first direction on.
/// @param support  extreme point of a - b along a direction
template <class Support>
void narrow_gap(const Support& support, LongVector way, Real scale, SolidGap& gap)
{
    GapSimplex simplex;
    simplex.add(support(way));
    for (int step = 0; step < 200; ++step) {
        gap.core_upper = std::min(gap.core_upper, simplex.distance), way = simplex.toward_origin;
        if (simplex.distance == 0) return;
        const LongVector w = support(way);
        if (const Real lower = -way.dot(w); lower > gap.core_lower) gap.core_lower = lower, gap.toward = way;
        if (gap.core_upper - gap.core_lower <= 1e-16L * std::max(1e-2L * scale, gap.core_upper) || simplex.has(w) ||
            !simplex.add(w))
            return;
    }
}

template <class Support>
SolidGap core_gap(const Support& support, const LongVector& between, Real scale)
{
    SolidGap gap;
    gap.core_upper = std::numeric_limits<Real>::infinity();
    LongVector way = between.norm() > 0 ? LongVector(between.normalized()) : LongVector::UnitX();
    // Slivers may end a search early; another one then begins elsewhere.
    for (int start = 0; start < 5; ++start) {
        narrow_gap(support, way, scale, gap);
        if (gap.core_upper - gap.core_lower <= 1e-15L * scale) break;
        const LongVector aside(std::cos(Real(start)), std::sin(Real(start)), 0.4L);
        way = (way + aside).normalized();
    }
    gap.core_lower = std::min(gap.core_lower, gap.core_upper);
    return gap;
}

SolidGap grown(SolidGap gap, Real radius)
{
    gap.lower = std::max(0.0L, gap.core_lower - radius), gap.upper = std::max(0.0L, gap.core_upper - radius);
    return gap;
}

/// Directions spread over the sphere.
const std::vector<LongVector>& sample_directions()
{
    static const std::vector<LongVector> all = [] {
        std::vector<LongVector> directions;
        const int count = 128;
        for (int k = 0; k < count; ++k) {
            const Real z = (2 * k + 1) / Real(count) - 1, turn = k * std::numbers::pi_v<Real> * (3 - std::sqrt(5.0L));
            const Real across = std::sqrt(1 - z * z);
            directions.emplace_back(across * std::cos(turn), across * std::sin(turn), z);
        }
        return directions;
    }();
    return all;
}

LongVector across(const LongVector& v)
{
    int least = 0;
    v.cwiseAbs().minCoeff(&least);
    return v.cross(LongVector::Unit(least)).normalized();
}

/// Collects directions and their widths.
class WidthSearch {
public:
    WidthSearch(const SolidTruth& a, const SolidTruth& b) : a_(a), b_(b) {}

    void try_along(const LongVector& unit) { tried_.push_back({width_along(a_, b_, unit), unit}); }
    void try_both(const LongVector& unit) { try_along(unit), try_along(-unit); }
    /// Tries the normals of faces, and the normals of the parallelograms of two edges.
    void try_features()
    {
        for (const SolidTruth* solid : {&a_, &b_}) {
            for (const LongVector& n : solid->faces()) try_both(n);
            for (const LongVector& e : solid->edges()) try_both(across(e));
        }
        for (const LongVector& e : a_.edges())
            for (const LongVector& f : b_.edges())
                if (const LongVector n = e.cross(f); n.squaredNorm() > 1e-30L) try_both(n.normalized());
    }
    /// Pattern search from the best few directions.
    void refine()
    {
        for (const LongVector& n : sample_directions()) try_along(n);
        const std::size_t starts = std::min<std::size_t>(5, tried_.size());
        std::partial_sort(tried_.begin(), tried_.begin() + std::ptrdiff_t(starts), tried_.end(),
                          [](const LeastWidth& u, const LeastWidth& v) { return u.width < v.width; });
        tried_.resize(starts);
        for (LeastWidth& from : tried_) descend(from);
    }
    LeastWidth best() const
    {
        return *std::ranges::min_element(tried_, {}, [](const LeastWidth& w) { return w.width; });
    }

private:
    void descend(LeastWidth& at) const
    {
        Real turn = 0;
        for (Real step = 0.15L; step > 1e-5L; turn += 0.7L) {
            const LongVector u = across(at.along), v = at.along.cross(u);
            bool better = false;
            for (int k = 0; k < 5; ++k) {
                const Real angle = turn + Real(k) * 2 * std::numbers::pi_v<Real> / 5;
                const LongVector n = (at.along + step * (std::cos(angle) * u + std::sin(angle) * v)).normalized();
                if (const Real width = width_along(a_, b_, n); width < at.width) at = {width, n}, better = true;
            }
            if (!better) step /= 2;
        }
    }

    const SolidTruth &a_, &b_;
    std::vector<LeastWidth> tried_;
};

} // namespace

SolidGap gap_of(const SolidTruth& a, const SolidTruth& b, const LongVector& shift)
{
    if (a.is_half_space() || b.is_half_space()) {
        const LongVector n = a.is_half_space() ? a.outward() : LongVector(-b.outward());
        const Real apart = -(a.height(n) + b.height(-n)) + n.dot(shift);
        SolidGap gap;
        gap.lower = gap.upper = std::max(apart, 0.0L), gap.toward = n;
        gap.core_lower = gap.core_upper = std::max(apart + a.radius() + b.radius(), 0.0L);
        return gap;
    }
    const LongVector between = b.centre() + shift - a.centre();
    const auto support = [&](const LongVector& way) -> LongVector {
        return a.core_support(way) - b.core_support(-way) - shift;
    };
    return grown(core_gap(support, between, a.size() + b.size() + between.norm()), a.radius() + b.radius());
}

SolidGap gap_to(const SolidTruth& a, const LongVector& point)
{
    const LongVector between = point - a.centre();
    const auto support = [&](const LongVector& way) -> LongVector { return a.core_support(way) - point; };
    return grown(core_gap(support, between, a.size() + between.norm()), a.radius());
}

long double width_along(const SolidTruth& a, const SolidTruth& b, const LongVector& unit)
{
    const LongVector n = a.is_half_space() ? a.outward() : b.is_half_space() ? LongVector(-b.outward()) : unit;
    return a.height(n) + b.height(-n);
}

LeastWidth least_width(const SolidTruth& a, const SolidTruth& b, const SolidGap& gap, const LongVector& hint)
{
    WidthSearch search(a, b);
    search.try_along(hint);
    if (a.is_half_space() || b.is_half_space()) return search.best();
    if (gap.core_lower > 0) { // the cores are farthest apart along the gap, in all directions
        search.try_along(gap.toward);
        if (gap.core_upper - gap.core_lower <= 1e-6L * gap.core_upper) return search.best();
    }
    const bool of_a = a.has_flat_core() && a.faces().empty() && a.edges().empty(),
               of_b = b.has_flat_core() && b.faces().empty() && b.edges().empty();
    if (of_a || of_b) { // a sphere: the depth of its centre
        const Real radius = of_b ? b.radius() : a.radius();
        const Real depth = radius - (of_b ? a.from_surface(b.centre()) : b.from_surface(a.centre()));
        return std::min(LeastWidth{depth, hint}, search.best(),
                        [](const LeastWidth& u, const LeastWidth& v) { return u.width < v.width; });
    }
    const LongVector between = b.centre() - a.centre();
    if (between.norm() > 0) search.try_along(between.normalized());
    search.try_features();
    if (!(a.has_flat_core() && b.has_flat_core())) search.refine();
    return search.best();
}

} // namespace oncollide::oracle
