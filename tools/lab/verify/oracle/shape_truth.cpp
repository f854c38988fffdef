#include "verify/oracle/shape_truth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "verify/oracle/solid_gap.hpp"

namespace oncollide::oracle {
namespace {

using Real = long double;
using Eigen::Vector3d;

double shown(Real value)
{
    return static_cast<double>(value);
}
std::string shown(const Vector3d& v)
{
    return fmt::format("({:.17g} {:.17g} {:.17g})", v.x(), v.y(), v.z());
}

LongVector placed(const Vector3d& point, const SolidTruth& solid)
{
    return point.cast<Real>() - solid.origin().cast<Real>();
}

bool same(double x, double y)
{
    return x == y || (std::isnan(x) && std::isnan(y));
}
bool same(const Vector3d& x, const Vector3d& y)
{
    return same(x.x(), y.x()) && same(x.y(), y.y()) && same(x.z(), y.z());
}
bool reversed(const ManifoldRegion& r, const ManifoldRegion& s)
{
    return r.kind == s.kind && r.open == s.open && same(r.normal, -s.normal) && same(r.normal_error, s.normal_error) &&
           same(r.area, s.area) && same(r.volume, s.volume) && same(r.centre, s.centre) &&
           same(r.depth_lower, s.depth_lower) && same(r.depth_upper, s.depth_upper) && same(r.lost, s.lost) &&
           r.first == s.first && r.count == s.count && r.found == s.found;
}
bool reversed(const ManifoldPoint& p, const ManifoldPoint& q)
{
    return same(p.point_a, q.point_b) && same(p.point_b, q.point_a) && same(p.depth, q.depth) &&
           same(p.depth_error, q.depth_error) && p.feature_a == q.feature_b && p.feature_b == q.feature_a &&
           same(p.normal, -q.normal);
}

/// Collects faults, the first of each claim.
class ShapeFaults {
public:
    template <class... Values>
    void expect(bool right, ShapeClaim claim, fmt::format_string<Values...> text, Values&&... values)
    {
        const std::uint32_t bit = 1u << static_cast<int>(claim);
        if (right || (seen_ & bit) != 0) return;
        seen_ |= bit;
        faults_.push_back({claim, fmt::format("{}: {}", shape_claims[static_cast<int>(claim)],
                                              fmt::format(text, std::forward<Values>(values)...))});
    }
    std::vector<ShapeFault> take() { return std::move(faults_); }

private:
    std::uint32_t seen_ = 0;
    std::vector<ShapeFault> faults_;
};

void judge_swapped(const Manifold& m, const Manifold& back, ShapeFaults& faults)
{
    const bool alike =
        m.complete == back.complete &&
        std::ranges::equal(m.regions, back.regions, [](const auto& r, const auto& s) { return reversed(r, s); }) &&
        std::ranges::equal(m.points, back.points, [](const auto& p, const auto& q) { return reversed(p, q); });
    faults.expect(alike, ShapeClaim::swapped, "the manifold of b and a is another one ({} and {} regions)",
                  m.regions.size(), back.regions.size());
}

void judge_presence(const SolidGap& gap, Real doubt, const ShapeAnswer& answer, ShapeFaults& faults)
{
    const bool none = answer.manifold.regions.empty();
    const double margin = answer.options.margin;
    faults.expect(!(none && answer.verdict != Verdict::separate), ShapeClaim::presence,
                  "no region, although decide() says {}", name_of(answer.verdict));
    faults.expect(!(none && gap.upper <= margin - doubt), ShapeClaim::presence,
                  "no region at distance {:.17g} with margin {:.17g}", shown(gap.upper), margin);
    // A body below a terrain or inside a closed mesh may be far from the surface.
    const bool enclosed = std::ranges::any_of(answer.manifold.regions,
                                              [](const ManifoldRegion& r) { return r.kind == RegionKind::enclosed; });
    const bool close = answer.verdict != Verdict::separate || gap.lower <= margin + doubt;
    faults.expect(none || enclosed || close, ShapeClaim::presence, "a region at distance {:.17g} with margin {:.17g}",
                  shown(gap.lower), margin);
}

class ShapeJudge {
public:
    ShapeJudge(const SolidTruth& a, const SolidTruth& b, const ShapeAnswer& answer)
        : a_(a), b_(b), answer_(answer), gap_(gap_of(a, b)),
          doubt_(1e-12L * (a.size() + b.size() + (b.centre() - a.centre()).norm())),
          smaller_(a.is_half_space()   ? b.size()
                   : b.is_half_space() ? a.size()
                                       : std::min(a.size(), b.size())),
          apart_(gap_.lower > doubt_)
    {
    }

    ShapeVerdict run()
    {
        const Manifold& m = answer_.manifold;
        judge_presence(gap_, doubt_, answer_, faults_);
        faults_.expect(m.regions.size() <= 1, ShapeClaim::one_region, "{} regions of two convex solids",
                       m.regions.size());
        judge_swapped(m, answer_.swapped, faults_);
        for (const ManifoldRegion& r : m.regions) {
            if (!judge_normal(r)) continue;
            if (m.regions.size() == 1) judge_depths(r);
            judge_points(r);
        }
        const Real margin = answer_.options.margin;
        return {faults_.take(), !apart_, apart_ && gap_.upper <= margin};
    }

private:
    /// False: nothing else can be judged.
    bool judge_normal(const ManifoldRegion& r)
    {
        const bool whole =
            r.first <= answer_.manifold.points.size() && r.count <= answer_.manifold.points.size() - r.first;
        faults_.expect(whole && r.count >= 1 && r.count <= answer_.options.points_per_region, ShapeClaim::one_region,
                       "{} points from {} of {}", r.count, r.first, answer_.manifold.points.size());
        const LongVector n = r.normal.cast<Real>();
        const bool unit = std::abs(n.norm() - 1) <= 1e-15L;
        faults_.expect(unit, ShapeClaim::normal, "{} has the length {:.17g}", shown(r.normal), shown(n.norm()));
        if (!unit || !whole) return false;
        faults_.expect(r.kind == RegionKind::near || !apart_, ShapeClaim::kind, "{} at distance {:.17g}",
                       name_of(r.kind), shown(gap_.lower));
        if (a_.is_half_space() || b_.is_half_space()) {
            const Real off = (n - gap_.toward.normalized()).norm();
            faults_.expect(off <= r.normal_error + 1e-12L, ShapeClaim::normal_error,
                           "{:.3g} at an angle of {:.3g} to the half-space's normal", r.normal_error, shown(off));
            faults_.expect(off <= 1e-6L, ShapeClaim::normal, "{} is not the half-space's", shown(r.normal));
            return off <= 1e-6L;
        }
        if (apart_ && gap_.core_lower > 0) {
            const Real own =
                std::sqrt((gap_.core_upper - gap_.core_lower) * (gap_.core_upper + gap_.core_lower)) / gap_.core_lower;
            const Real angle = 2 * std::asin(std::min((n - gap_.toward).norm() / 2, 1.0L));
            faults_.expect(angle <= r.normal_error + own + doubt_ / gap_.core_lower, ShapeClaim::normal_error,
                           "{:.3g} at an angle of {:.3g} to the gap", r.normal_error, shown(angle));
        }
        return true;
    }

    void judge_depths(const ManifoldRegion& r)
    {
        const LongVector n = r.normal.cast<Real>();
        const Real lower = r.depth_lower, upper = r.depth_upper, width = width_along(a_, b_, n);
        faults_.expect(std::isfinite(upper) && std::isfinite(lower) && lower <= upper, ShapeClaim::depth_lower,
                       "{:.17g} and depth_upper {:.17g}", r.depth_lower, r.depth_upper);
        if (!std::isfinite(upper) || !std::isfinite(lower)) return;
        Real least;
        if (apart_) {
            faults_.expect(upper >= -gap_.upper - doubt_, ShapeClaim::depth_upper, "{:.17g} at distance {:.17g}",
                           r.depth_upper, shown(gap_.upper));
            // The plane after the way may also be across the gap.
            const Real rest = std::min(width - upper, width_along(a_, b_, gap_.toward) - upper * n.dot(gap_.toward));
            faults_.expect(rest <= doubt_, ShapeClaim::depth_upper, "{:.17g}: the two are then still {:.17g} deep",
                           r.depth_upper, shown(rest));
            faults_.expect(lower <= -gap_.lower + doubt_, ShapeClaim::depth_lower, "{:.17g} at distance {:.17g}",
                           r.depth_lower, shown(gap_.lower));
            least = -gap_.lower;
        } else {
            faults_.expect(upper >= width - doubt_, ShapeClaim::depth_upper,
                           "{:.17g}, but the width along {} is {:.17g}", r.depth_upper, shown(r.normal), shown(width));
            faults_.expect(upper <= width + 1e-9L * smaller_ + doubt_, ShapeClaim::tight_upper,
                           "{:.17g}, but the width along {} is {:.17g}", r.depth_upper, shown(r.normal), shown(width));
            if (lower > doubt_) {
                const Real after = gap_of(a_, b_, lower * n).lower;
                faults_.expect(after <= doubt_, ShapeClaim::depth_lower, "{:.17g}: the two are then {:.17g} apart",
                               r.depth_lower, shown(after));
            }
            const LeastWidth shortest = least_width(a_, b_, gap_, n);
            least = std::max(0.0L, shortest.width);
            faults_.expect(lower <= least + doubt_, ShapeClaim::depth_lower, "{:.17g}, but {:.17g} along {} parts them",
                           r.depth_lower, shown(least), shown(Vector3d(shortest.along.cast<double>())));
        }
        faults_.expect(upper <= least + 0.01L * std::abs(least) + 1e-6L * smaller_ + doubt_, ShapeClaim::least,
                       "{:.17g} along {}, but {:.17g} is enough", r.depth_upper, shown(r.normal), shown(least));
    }

    void judge_points(const ManifoldRegion& r)
    {
        const std::span points(answer_.manifold.points.data() + r.first, r.count);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const ManifoldPoint& p = points[i];
            const bool finite = p.point_a.allFinite() && p.point_b.allFinite() && p.depth_error >= 0 &&
                                std::isfinite(p.depth) && std::isfinite(p.depth_error);
            faults_.expect(finite, ShapeClaim::depth, "{:.17g} +- {:.17g}", p.depth, p.depth_error);
            if (!finite) continue;
            const Real rounding =
                doubt_ + 0x1p-50L * std::max(p.point_a.cwiseAbs().maxCoeff(), p.point_b.cwiseAbs().maxCoeff());
            const Real off_a = std::abs(a_.from_surface(placed(p.point_a, a_))),
                       off_b = std::abs(b_.from_surface(placed(p.point_b, b_)));
            faults_.expect(off_a <= p.depth_error + rounding, ShapeClaim::surface,
                           "point_a {} is {:.3g} off, and its error {:.3g}", shown(p.point_a), shown(off_a),
                           p.depth_error);
            faults_.expect(off_b <= p.depth_error + rounding, ShapeClaim::surface,
                           "point_b {} is {:.3g} off, and its error {:.3g}", shown(p.point_b), shown(off_b),
                           p.depth_error);
            const Real off =
                (placed(p.point_a, a_) - placed(p.point_b, a_) - Real(p.depth) * r.normal.cast<Real>()).norm();
            faults_.expect(off <= rounding, ShapeClaim::offset,
                           "point_a {} and point_b {} of depth {:.17g}: {:.3g} off", shown(p.point_a), shown(p.point_b),
                           p.depth, shown(off));
            faults_.expect(p.depth - p.depth_error <= r.depth_upper + doubt_, ShapeClaim::depth,
                           "{:.17g} - {:.17g} is above depth_upper {:.17g}", p.depth, p.depth_error, r.depth_upper);
            faults_.expect(std::abs(p.normal.norm() - 1) <= 1e-15 && p.normal.dot(r.normal) >= 0.7071,
                           ShapeClaim::normal, "{} of a point, {} of the region", shown(p.normal), shown(r.normal));
            if (rounding > 1e-6L * smaller_) continue; // points of one place may be different
            for (std::size_t k = 0; k < i; ++k) {
                const ManifoldPoint& q = points[k];
                const bool apart =
                    (p.point_a - q.point_a).norm() > rounding || (p.point_b - q.point_b).norm() > rounding;
                faults_.expect(apart || p.normal.dot(q.normal) < 1 - 1e-9, ShapeClaim::repeated, "{} and {}",
                               shown(p.point_a), shown(q.point_a));
            }
        }
    }

    const SolidTruth &a_, &b_;
    const ShapeAnswer& answer_;
    const SolidGap gap_;
    const Real doubt_, smaller_;
    const bool apart_; ///< certainly
    ShapeFaults faults_;
};

} // namespace

ShapeVerdict judge_shapes(const SolidTruth& a, const SolidTruth& b, const ShapeAnswer& answer)
{
    return ShapeJudge(a, b, answer).run();
}

namespace {

void judge_region_on_ground(std::span<const SolidTruth> parts, const SolidGap& gap, Real doubt, const SolidTruth& solid,
                            bool solid_is_a, const ShapeAnswer& answer, const ManifoldRegion& r, ShapeFaults& faults)
{
    const bool enclosed = r.kind == RegionKind::enclosed;
    faults.expect(std::abs(r.normal.norm() - 1) <= 1e-15, ShapeClaim::normal, "{} is not unit", shown(r.normal));
    const bool apart = answer.verdict == Verdict::separate && gap.lower > doubt;
    faults.expect(!apart || enclosed || r.kind == RegionKind::near, ShapeClaim::kind, "{} at distance {:.17g}",
                  name_of(r.kind), shown(gap.lower));
    faults.expect(r.depth_lower <= r.depth_upper && std::isfinite(r.depth_upper), ShapeClaim::depth_lower,
                  "{:.17g} and depth_upper {:.17g}", r.depth_lower, r.depth_upper);
    const LongVector out = Real(solid_is_a ? -1 : 1) * r.normal.cast<Real>(); // the solid moves along it
    // After the lower depth they still meet; an enclosed body, too, though perhaps no surface.
    if (r.depth_lower > doubt && !enclosed)
        faults.expect(std::ranges::any_of(parts,
                                          [&](const SolidTruth& part) {
                                              return gap_of(part, solid, Real(r.depth_lower) * out).lower <= doubt;
                                          }),
                      ShapeClaim::depth_lower, "{:.17g}: the two are then apart", r.depth_lower);
    for (std::uint32_t k = r.first; k < r.first + r.count; ++k) {
        const ManifoldPoint& p = answer.manifold.points[k];
        const Vector3d& at = solid_is_a ? p.point_a : p.point_b;
        const Real error = p.depth_error + doubt + 0x1p-50L * at.cwiseAbs().maxCoeff();
        const Real off = std::abs(solid.from_surface(placed(at, solid)));
        faults.expect(off <= error, ShapeClaim::surface, "{} of the solid is {:.3g} off, and its error {:.3g}",
                      shown(at), shown(off), p.depth_error);
        faults.expect(p.depth - p.depth_error <= r.depth_upper + doubt, ShapeClaim::depth,
                      "{:.17g} - {:.17g} is above depth_upper {:.17g}", p.depth, p.depth_error, r.depth_upper);
    }
}

} // namespace

ShapeVerdict judge_on_ground(std::span<const SolidTruth> parts, bool may_be_below, const SolidTruth& solid,
                             bool solid_is_a, const ShapeAnswer& answer)
{
    ShapeFaults faults;
    SolidGap gap;
    gap.lower = gap.upper = std::numeric_limits<Real>::infinity();
    Real extent = 0;
    for (const SolidTruth& part : parts) {
        const Real between = (part.centre() - solid.centre()).norm();
        extent = std::max(extent, between + part.size());
        if (between - (part.size() + solid.size()) > gap.upper) continue; // a size bounds a radius
        const SolidGap to = gap_of(solid, part);
        gap.lower = std::min(gap.lower, to.lower), gap.upper = std::min(gap.upper, to.upper);
    }
    const Real doubt = 1e-12L * (extent + solid.size());
    if (may_be_below) gap.lower = 0;
    judge_presence(gap, doubt, answer, faults);
    judge_swapped(answer.manifold, answer.swapped, faults);
    for (const ManifoldRegion& r : answer.manifold.regions)
        judge_region_on_ground(parts, gap, doubt, solid, solid_is_a, answer, r, faults);
    const bool apart = gap.lower > doubt;
    return {faults.take(), !apart, apart && gap.upper <= answer.options.margin};
}

} // namespace oncollide::oracle
