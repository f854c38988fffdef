#include <oncollide/narrowphase/hulls/outer_hull.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <oncollide/broadphase/aabb_kernel.hpp>
#include <oncollide/narrowphase/shapes/simplex.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// Share of the box's diagonal: vertices farther than this from the hull of the chosen vertices are chosen, too.
constexpr double most_cover = 0x1p-8;
constexpr std::size_t most_points = 512;

std::uint32_t number_of_farthest(const PointColumns& points, const Vector3f& direction)
{
    const auto& [x, y, z] = points.xyz;
    return aabb_kernel().farthest(x.data(), y.data(), z.data(), static_cast<std::uint32_t>(x.size()), direction.data());
}

Vector3d point(const PointColumns& points, std::size_t i)
{
    return Vector3f(points.xyz[0][i], points.xyz[1][i], points.xyz[2][i]).cast<double>();
}

/// Searches the difference of two convex sets, b - a, for the point nearest to 0 (Gilbert, Johnson and Keerthi, "A fast
/// procedure for computing the distance between complex objects in three-dimensional space", 1988).
struct Search {
    double lower = -std::numeric_limits<double>::infinity(); ///< lower bound of the distance, if > 0, within rounding
    double upper = std::numeric_limits<double>::infinity();  ///< distance of the nearest point found
    Vector3d across = Vector3d::Zero();                      ///< unit direction that gave `lower`

    Simplex4 simplex; ///< the points found; may initially hold some

    /// @param v        the first direction, for a simplex without points
    /// @param support  (direction of length 1) -> the point with the smallest projection onto it
    /// @param enough   (*this) -> true ends the search
    void run(Vector3d v, auto support, auto enough)
    {
        constexpr int most_steps = 32;
        if (simplex.count > 0 && !nearer(v)) return;
        for (int step = 0; step < most_steps && !enough(*this); ++step) {
            const double length = v.norm();
            if (!(length > 0)) return;
            const Vector3d n = v / length;
            const ConvexDifference::Point p = support(n);
            if (const double least = n.dot(p.w); least > lower) lower = least, across = n;
            if (enough(*this) || simplex.holds(p.w)) return;
            simplex.corner[simplex.count++] = p;
            if (!nearer(v)) return;
        }
    }

private:
    /// Sets v to the nearest point of the simplex. False: it is 0, or no nearer than before.
    bool nearer(Vector3d& v)
    {
        simplex.reduce();
        v = simplex.nearest();
        const double nearest = simplex.count == 4 ? 0 : v.norm();
        if (!(nearest < upper)) return false;
        upper = nearest;
        return upper > 0;
    }
};

} // namespace

OuterHull::OuterHull(const Mesh& mesh) : centre_(mesh.bounds.centre())
{
    const PointColumns all = used_points(mesh, centre_);
    std::vector<bool> chosen(all.size());
    constexpr int side = 2;
    for (int x = -side; x <= side; ++x)
        for (int y = -side; y <= side; ++y)
            for (int z = -side; z <= side; ++z) {
                if (std::max({std::abs(x), std::abs(y), std::abs(z)}) < side) continue;
                const Vector3f d = Vector3f(float(x), float(y), float(z)).normalized();
                const std::uint32_t i = number_of_farthest(all, d);
                if (!chosen[i]) chosen[i] = true, add(all, i);
            }
    const double allowed = most_cover * mesh.bounds.diagonal();
    Simplex4 last; // simplex of the previous vertex, which is usually close by
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (chosen[i]) continue;
        const Vector3d p = point(all, i);
        const bool full = count_ >= most_points;
        const double bar = full ? std::max(cover_, allowed) : allowed;
        Search search;
        search.simplex = last;
        for (int k = 0; k < last.count; ++k) search.simplex.corner[k].w = p - last.corner[k].a;
        search.run(
            p,
            [&](const Vector3d& n) {
                const Vector3d q = farthest(n.cast<float>());
                return ConvexDifference::Point{p - q, q};
            },
            [&](const Search& s) { return s.upper <= bar || (!full && s.lower > bar); });
        last = search.simplex;
        if (search.upper > bar && !full)
            add(all, i);
        else
            cover_ = std::max(cover_, search.upper);
    }
    for (std::vector<float>& column : points_.xyz) column.shrink_to_fit();
    // Adds the rounding of points to floats, which near 0 are 2^-149 apart, and of the search.
    const double reach = mesh.bounds.half_extent().norm();
    cover_ = cover_ * (1 + 0x1p-20) + 0x1p-22 * reach + 0x1p-148;
    extent_ = reach * (1 + 0x1p-20);
}

/// Replaces a padding copy, if there is one.
void OuterHull::add(const PointColumns& from, std::size_t i)
{
    if (count_ == points_.size())
        for (int k = 0; k < 8; ++k) points_.add(from, i);
    for (std::size_t k = count_; k < points_.size(); ++k)
        for (std::size_t axis = 0; axis < 3; ++axis) points_.xyz[axis][k] = from.xyz[axis][i];
    ++count_;
}

Vector3d OuterHull::farthest(const Vector3f& direction) const
{
    return point(points_, number_of_farthest(points_, direction));
}

namespace {

/// Poses may be 2^-20 from rigid. The projection of a support point found in float may be too small by 2^-21 of the
/// extent, and by as much again because the direction was rotated and rounded.
double covered_by(const OuterHull& a, const OuterHull& b, const RelativePose& b_to_a)
{
    const double rounding = 0x1p-18 * (a.extent() + b.extent()) + 0x1p-46 * b_to_a.translation.norm();
    return (a.cover() + b.cover()) * (1 + 0x1p-18) + rounding;
}

/// The vector from A's support point along `n` to B's support point along -n, and A's support point.
ConvexDifference::Point supports(const OuterHull& a, const OuterHull& b, const RelativePose& b_to_a, const Vector3d& n)
{
    const Vector3d of_a = a.farthest(n.cast<float>());
    const Vector3d of_b = b.farthest((b_to_a.rotation.transpose() * -n).cast<float>());
    return {b_to_a(b.centre()) - a.centre() + b_to_a.rotation * of_b - of_a, of_a};
}

} // namespace

HullGap hull_gap(const OuterHull& a, const OuterHull& b, const RelativePose& b_to_a, const Vector3f& first,
                 double enough)
{
    const double covered = covered_by(a, b, b_to_a);
    Search search;
    search.run(
        first.isZero(0) ? Vector3d(b_to_a(b.centre()) - a.centre()) : first.cast<double>(),
        [&](const Vector3d& n) { return supports(a, b, b_to_a, n); },
        [&](const Search& s) { return s.upper <= covered || s.lower >= 0.9 * s.upper || s.lower - covered >= enough; });
    const double gap = (search.lower - covered) * (1 - 0x1p-18);
    return {std::max(gap, 0.0), search.across.cast<float>()};
}

double gap_along(const OuterHull& a, const OuterHull& b, const RelativePose& b_to_a, const Vector3d& direction)
{
    const double gap = direction.dot(supports(a, b, b_to_a, direction).w) - covered_by(a, b, b_to_a);
    return gap - 0x1p-18 * std::abs(gap);
}

} // namespace oncollide
