#include <oncollide/narrowphase/pairs/manifolds/near_pairs.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/feature_distance.hpp>
#include <oncollide/narrowphase/pairs/manifold_tests.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/manifold_limits.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

FeatureBits feature(const PlacedSurface& surface, std::uint32_t triangle, std::uint8_t corners)
{
    if (corners == 7) return surface.face(triangle);
    const auto v = surface.corners(triangle);
    std::array<std::uint32_t, 2> of{};
    int count = 0;
    for (int k = 0; k < 3; ++k)
        if (corners >> k & 1) of[count++] = v[k];
    return count == 2 ? surface.edge(of[0], of[1]) : surface.vertex(of[0]);
}

/// The edge, by its first corner, that two corners of a triangle span.
int edge_of(std::uint8_t corners)
{
    return corners == 3 ? 0 : corners == 6 ? 1 : 2;
}

/// Calls visit(triangle) for the triangles around a feature, first the given one, while it returns true.
void visit_around(const PlacedSurface& surface, std::uint32_t triangle, std::uint8_t corners, auto visit)
{
    if (!visit(triangle) || corners == 7) return;
    if (std::popcount(corners) == 2) {
        if (const std::uint32_t t = surface.across(triangle, edge_of(corners)); t != PlacedSurface::none) visit(t);
        return;
    }
    const std::uint32_t shared = surface.corners(triangle)[std::countr_zero(corners)];
    std::uint32_t t = triangle;
    for (int steps = 0; steps < manifold_limits::most_around; ++steps) {
        const auto v = surface.corners(t);
        t = surface.across(t, v[0] == shared ? 0 : v[1] == shared ? 1 : 2);
        if (t == PlacedSurface::none || t == triangle || !visit(t)) return;
    }
}

/// True if `from` is in front of one of the triangles around a feature, and no point of the surface near the feature's
/// point is nearer to it.
bool is_minimum(const PlacedSurface& surface, std::uint32_t triangle, std::uint8_t corners, const Vector3d& at,
                const Vector3d& from)
{
    const Vector3d out = from - at;
    const double distance = out.norm(), tolerance = manifold_limits::rising * distance;
    const double least = corners == 7 ? 0 : manifold_limits::behind_share * distance;
    bool in_front = false, falls = false;
    visit_around(surface, triangle, corners, [&](std::uint32_t t) {
        const TrianglePoints p = surface.points(t);
        if (!in_front) {
            const Vector3d n = (p[1] - p[0]).cross(p[2] - p[0]);
            in_front = out.dot(n) > least * n.norm();
        }
        if (corners != 7)
            for (const Vector3d& q : p)
                if (const double length = (q - at).norm(); length > 0) falls |= out.dot(q - at) > tolerance * length;
        return !falls;
    });
    return in_front && !falls;
}

/// Bits of the corners, and of the edges that begin at them, which may be within `reach` of a triangle, judging by the
/// distance from its plane.
struct InReach {
    unsigned corners = 0, edges = 0;
    /// @param normal  the unit normal of the triangle `of`; 0 without area
    InReach(const TrianglePoints& t, const TrianglePoints& of, const Vector3d& normal, double reach)
    {
        double height[3];
        for (int k = 0; k < 3; ++k) height[k] = normal.dot(t[k] - of[0]);
        for (int k = 0; k < 3; ++k) {
            const double from = height[k], to = height[(k + 1) % 3];
            corners |= unsigned(!(std::abs(from) > reach)) << k;
            edges |= unsigned(!(std::min(from, to) > reach || std::max(from, to) < -reach)) << k;
        }
    }
    bool any() const { return (corners | edges) != 0; }
};

/// Sorts by features, and keeps of equal ones the nearest.
void sort_once(std::vector<NearPair>& found)
{
    struct Key {
        FeatureBits a, b;
        double distance;
        std::uint32_t triangle_a, triangle_b, at;
    };
    std::vector<Key> keys;
    keys.reserve(found.size());
    for (const NearPair& p : found)
        keys.push_back({p.a, p.b, p.distance, p.triangle_a, p.triangle_b, static_cast<std::uint32_t>(keys.size())});
    std::ranges::sort(keys, {},
                      [](const Key& k) { return std::tuple(k.a, k.b, k.distance, k.triangle_a, k.triangle_b); });
    const auto same_pair = [](const Key& x, const Key& y) { return x.a == y.a && x.b == y.b; };
    keys.erase(std::unique(keys.begin(), keys.end(), same_pair), keys.end());
    std::vector<NearPair> sorted;
    sorted.reserve(keys.size());
    for (const Key& k : keys) sorted.push_back(found[k.at]);
    found.swap(sorted);
}

} // namespace

bool NearSearch::Face::owns(std::uint8_t spanned) const
{
    if (spanned == 7) return true;
    return std::popcount(spanned) == 1 ? (corners & spanned) != 0 : edges >> edge_of(spanned) & 1;
}

void NearSearch::Side::set(const PlacedSurface& of, std::span<const TrianglePair> near, bool is_a, Which which)
{
    surface = &of;
    triangles.clear(), vertices.clear(), edges.clear(), number.clear(), faces.clear();
    bool is_new;
    for (const TrianglePair& pair : near)
        if (const std::uint32_t t = is_a ? pair.a : pair.b; triangles.add(t, is_new), is_new) number.push_back(t);
    for (const std::uint32_t t : number) {
        Face& face = faces.emplace_back();
        face.triangle = t, face.points = of.points(t);
        face.normal = unit_normal(face.points[0], face.points[1], face.points[2]);
    }
    std::vector<std::uint32_t> order(faces.size()); // the same for any order of the pairs
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::sort(order, {}, [&](std::uint32_t i) { return std::pair(faces[i].normal.isZero(0), number[i]); });
    for (const std::uint32_t i : order) {
        Face& face = faces[i];
        const auto v = of.corners(face.triangle);
        for (int k = 0; k < 3; ++k) {
            const auto [low, high] = std::minmax(v[k], v[(k + 1) % 3]);
            if (vertices.add(v[k], is_new), is_new) face.corners |= 1u << k;
            if (edges.add(std::uint64_t{low} << 32 | high, is_new), is_new) face.edges |= 1u << k;
            // If the distance has a minimum at a feature that does not stick out, it also has one beside it.
            const bool all = which == Which::all;
            if (all || of.corner_sticks_out(v[k])) face.tried_corners |= face.corners & 1u << k;
            if (all || of.edge_sticks_out(face.triangle, k)) face.tried_edges |= face.edges & 1u << k;
        }
    }
}

void NearSearch::add(const Face& a, std::uint8_t corners_a, const Vector3d& at_a, const Face& b, std::uint8_t corners_b,
                     const Vector3d& at_b)
{
    const double distance2 = (at_a - at_b).squaredNorm();
    if (distance2 > most_ * most_ * (1 + 0x1p-40)) return;
    const double distance = std::sqrt(distance2);
    if (distance > most_) return;
    least_ = std::min(least_, distance);
    if (which_ == Which::minima && (!(distance > rounding_) || !a.owns(corners_a) || !b.owns(corners_b) ||
                                    !is_minimum(*a_.surface, a.triangle, corners_a, at_a, at_b) ||
                                    !is_minimum(*b_.surface, b.triangle, corners_b, at_b, at_a)))
        return;
    found_->push_back({feature(*a_.surface, a.triangle, corners_a), feature(*b_.surface, b.triangle, corners_b),
                       a.triangle, b.triangle, corners_a, corners_b, at_a, at_b, distance});
}

void NearSearch::try_pair(const Face& a, const Face& b)
{
    const InReach near_a(a.points, b.points, b.normal, reach_), near_b(b.points, a.points, a.normal, reach_);
    if (!near_a.any() || !near_b.any()) return;
    const unsigned corners_a = a.tried_corners & near_a.corners, corners_b = b.tried_corners & near_b.corners,
                   edges_a = a.tried_edges & near_a.edges, edges_b = b.tried_edges & near_b.edges;
    const double allowed = 0.5 * rounding_; // the rest is for the corners as placed
    for (int k = 0; k < 3; ++k) {
        if (corners_a >> k & 1) {
            const auto on_b = nearest_on(b.points, a.points[k], allowed, most_);
            add(a, 1 << k, a.points[k], b, on_b.corners, on_b.at);
        }
        if (corners_b >> k & 1) {
            const auto on_a = nearest_on(a.points, b.points[k], allowed, most_);
            add(a, on_a.corners, on_a.at, b, 1 << k, b.points[k]);
        }
    }
    for (unsigned of_a = edges_b ? edges_a : 0; of_a; of_a &= of_a - 1)
        for (unsigned of_b = edges_b; of_b; of_b &= of_b - 1) {
            const int i = std::countr_zero(of_a), k = std::countr_zero(of_b), i2 = (i + 1) % 3, k2 = (k + 1) % 3;
            const Vector3d d = a.points[i2] - a.points[i], e = b.points[k2] - b.points[k];
            const auto [s, t, distance] =
                nearest_of_segments(a.points[i], a.points[i2], b.points[k], b.points[k2], allowed, most_);
            if (distance > most_ * (1 + 0x1p-40)) continue;
            if (which_ == Which::minima && (s <= 0 || s >= 1 || t <= 0 || t >= 1)) continue; // found at the corner
            const auto spanned = [](int first, int last, double at) {
                return std::uint8_t(at <= 0 ? 1 << first : at >= 1 ? 1 << last : 1 << first | 1 << last);
            };
            add(a, spanned(i, i2, s), a.points[i] + s * d, b, spanned(k, k2, t), b.points[k] + t * e);
        }
}

void NearSearch::find(const PlacedSurface& a, const PlacedSurface& b, std::span<const TrianglePair> near, double dhat,
                      double rounding, Which which, std::vector<NearPair>& found)
{
    which_ = which, rounding_ = rounding, found_ = &found, least_ = std::numeric_limits<double>::infinity();
    most_ = dhat + rounding, reach_ = most_ * (1 + 0x1p-20) + rounding;
    found.clear();
    a_.set(a, near, true, which), b_.set(b, near, false, which);
    for (const TrianglePair& pair : near) {
        const Face &of_a = a_.faces[a_.triangles.find(pair.a)], &of_b = b_.faces[b_.triangles.find(pair.b)];
        if (of_a.tried_corners | of_b.tried_corners || (of_a.tried_edges && of_b.tried_edges)) try_pair(of_a, of_b);
    }
    sort_once(found);
}

double near_rounding(const PlacedSurface& a, const PlacedSurface& b)
{
    return 4 * rounding_of(a, b);
}

void near_features_of(PairWorker& worker, const PairTask& task, double dhat, std::vector<NearFeatures>& found)
{
    const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
    const RelativePose b_to_a(*task.pose_a, *task.pose_b);
    const PlacedSurface a(*task.a, RelativePose(here, here), {}, false), b(*task.b, b_to_a, {}, false);
    const double slack = slack_of(task);
    const double rounding = near_rounding(a, b) + slack * dhat + a.error() + b.error();
    a.with_tree([&](auto& tree_a) {
        b.with_tree([&](auto& tree_b) {
            worker.traversal(tree_a, tree_b).all_near(tree_a, tree_b, b_to_a, dhat + rounding, worker.pairs);
        });
    });
    NearSearch search;
    std::vector<NearPair> near;
    search.find(a, b, worker.pairs, dhat, rounding, NearSearch::Which::all, near);
    for (const NearPair& p : near)
        found.push_back({p.a, p.b, std::max(p.distance - rounding, 0.0), p.distance + rounding,
                         *task.pose_a * p.point_a, *task.pose_a * p.point_b});
}

} // namespace oncollide
