#include <oncollide/narrowphase/pairs/manifolds/round_solids.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <oncollide/narrowphase/pairs/manifolds/points/manifold_limits.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/support_points.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/narrowphase/pairs/part_solid.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/shapes/convex_pair.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

/// The ends of the common part of two nearly parallel segments, as parameters of the first; empty for others.
std::vector<double> shared(const Vector3d& p, const Vector3d& u, const Vector3d& q, const Vector3d& v)
{
    const double length2 = u.squaredNorm();
    const double from = u.dot(q - p) / length2, to = u.dot(q + v - p) / length2;
    const double low = std::clamp(std::min(from, to), 0.0, 1.0), high = std::clamp(std::max(from, to), 0.0, 1.0);
    if (u.cross(v).norm() > manifold_limits::parallel_sine * u.norm() * v.norm() || !(high > low)) return {};
    return {low, high};
}

/// A direction from a to b in a's frame, and by how much they overlap along it; negative: a gap.
struct Width {
    Vector3d along;
    double overlap;
};

/// If the solids are apart, the direction from nearest point to nearest point. If they overlap, the direction of least
/// overlap, by descent from several starts.
Width least_width(const Convex& a, const Convex& b, const RelativePose& into, const ConvexDistance& nearest, bool apart,
                  double size)
{
    const auto width = [&](const Vector3d& n) { // by which b moves along n until they are apart
        return a.most_along(n) + b.most_along(into.rotation.transpose() * -n) - n.dot(into.translation);
    };
    Vector3d n = nearest.on_b - nearest.on_a;
    if (!apart) n = -n;
    if (n.norm() <= 0x1p-40 * size) n = into(b.centre) - a.centre;
    n = n.norm() > 0 ? Vector3d(n.normalized()) : Vector3d::UnitZ();
    double least = width(n);
    const auto look = [&](const Vector3d& direction) {
        const double w = width(direction);
        if (w < least) n = direction, least = w;
    };
    if (!apart) {
        if (const Vector3d middle = into(b.centre) - a.centre; middle.norm() > 0x1p-40 * size)
            look(middle.normalized());
        for (int axis = 0; axis < 3; ++axis)
            for (const double sign : {-1.0, 1.0})
                look(sign * Vector3d::Unit(axis)), look(sign * into.rotation.col(axis).normalized());
    }
    int moves = 0; // moves with the current step
    for (double step = manifold_limits::first_step; step > manifold_limits::last_step; step /= 2) {
        const Vector3d from = n, u = n.unitOrthogonal(), v = n.cross(u);
        for (const Vector3d& side : {u, v, Vector3d(-u), Vector3d(-v)}) look((from + step * side).normalized());
        moves = n != from && moves < manifold_limits::most_moves ? moves + 1 : 0;
        if (moves > 0) step *= 2;
    }
    return {n, least};
}

/// Points of a and of b along the direction: for two parallel lines (of capsules, or the sides of cylinders) the ends
/// of their common part that are at least `least_depth` deep, else one pair of points.
std::vector<std::pair<Vector3d, Vector3d>> points_along(const Vector3d& n, const Convex& a, const Convex& b,
                                                        const RelativePose& into, const ConvexDistance& nearest,
                                                        double least_depth)
{
    const std::vector<Vector3d> of_a = support_points(a, n), of_b = support_points(b, into.rotation.transpose() * -n);
    const Vector3d tip_a = of_a[0], tip_b = into(of_b[0]);
    std::vector<std::pair<Vector3d, Vector3d>> points;
    if (of_a.size() > 1 && of_b.size() > 1) {
        const Vector3d end_a = of_a.size() == 2 ? of_a[1] : of_a.back(),
                       end_b = into(of_b.size() == 2 ? of_b[1] : of_b.back());
        for (const double t : shared(tip_a, end_a - tip_a, tip_b, end_b - tip_b)) {
            const Vector3d on_a = tip_a + t * (end_a - tip_a), line = end_b - tip_b;
            points.emplace_back(on_a, tip_b + std::clamp(line.dot(on_a - tip_b) / line.squaredNorm(), 0.0, 1.0) * line);
        }
        std::erase_if(points, [&](const auto& p) { return n.dot(p.first - p.second) < least_depth; });
    }
    if (points.empty()) {
        const Vector3d middle = 0.5 * (nearest.on_a + nearest.on_b);
        points.emplace_back(middle + n * (n.dot(tip_a) - n.dot(middle)), middle + n * (n.dot(tip_b) - n.dot(middle)));
    }
    return points;
}

} // namespace

void manifold_of_solids(PairWorker& worker, const PairTask& task, const ManifoldOptions& options, Manifold& manifold)
{
    const PlacedPair placed(*task.pose_a, *task.pose_b);
    const Convex &a = task.a->convex(), &b = task.b->convex();
    const Finding found = tests_for(task).decide(worker, task, {}, nullptr);
    const bool apart = found.verdict == Verdict::separate;
    if (apart && found.bound > options.margin) return;
    const ConvexDistance nearest = ConvexPair(a, b, placed.b_to_a, placed.slack).distance(nearest_of_all);
    const double size = a.extent + a.radius + b.extent + b.radius + placed.b_to_a.translation.norm();
    if (apart && nearest.lower > options.margin) return;
    const auto [n, least] = least_width(a, b, placed.b_to_a, nearest, apart, size);
    const double rounding = 0x1p-42 * size * (1 + placed.slack);
    if (-least > options.margin + rounding) return;
    ManifoldRegion region{};
    region.kind = least < -rounding   ? RegionKind::near
                  : least <= rounding ? RegionKind::touching
                                      : RegionKind::crossing;
    region.normal = n;
    region.normal_error =
        least > rounding ? std::min(std::numbers::pi, std::sqrt(rounding / least) + 0x1p-14) : 0x1p-14;
    const auto points =
        points_along(n, a, b, placed.b_to_a, nearest, least - 0.5 * std::abs(least) - options.margin - rounding);
    region.count = region.found = static_cast<std::uint32_t>(points.size());
    region.depth_lower = apart ? least - rounding : 0, region.depth_upper = std::max(least, 0.0) + rounding;
    if (apart) region.depth_upper = least + rounding;
    region.centre.setZero();
    std::uint64_t number = 0;
    for (const auto& [on_a, on_b] : points) {
        const double depth = n.dot(on_a - on_b);
        const FeatureBits feature = FeatureBits{3} << 62 | number++;
        // The chord through a point is no longer than the width.
        manifold.points.push_back(
            {on_a, on_b, depth, std::max(least - depth, 0.0) + std::abs(least) + rounding, feature, feature, n});
        region.centre += 0.5 / double(points.size()) * (on_a + on_b);
    }
    for (const Vector3d& p : {nearest.on_a, nearest.on_b})
        region.lost = std::max(region.lost, (p - region.centre).norm());
    manifold.regions.push_back(region);
}

} // namespace oncollide
