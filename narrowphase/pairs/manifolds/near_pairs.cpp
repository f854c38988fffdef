#include <oncollide/narrowphase/pairs/manifolds/near_pairs.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <oncollide/narrowphase/pairs/manifold_tests.hpp>
#include <oncollide/narrowphase/pairs/manifolds/region_draft.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

struct OnTriangle {
    Vector3d at;
    std::uint8_t corners;
};

/// The nearest point of a triangle. Source: Ericson, "Real-Time Collision Detection", 2004, 5.1.5.
OnTriangle nearest_on(const TrianglePoints& t, const Vector3d& p)
{
    const Vector3d ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0], bp = p - t[1], cp = p - t[2];
    const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d1 <= 0 && d2 <= 0) return {t[0], 1};
    if (d3 >= 0 && d4 <= d3) return {t[1], 2};
    if (d6 >= 0 && d5 <= d6) return {t[2], 4};
    const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return {t[0] + d1 / (d1 - d3) * ab, 3};
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return {t[0] + d2 / (d2 - d6) * ac, 5};
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return {t[1] + (d4 - d3) / (d4 - d3 + (d5 - d6)) * (t[2] - t[1]), 6};
    const double sum = va + vb + vc;
    return {t[0] + vb / sum * ab + vc / sum * ac, 7};
}

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

/// Nearest points of two segments, as parameters. Source: Ericson, 5.1.9.
std::pair<double, double> nearest_of(const Vector3d& p, const Vector3d& d, const Vector3d& q, const Vector3d& e)
{
    const Vector3d r = p - q;
    const double a = d.squaredNorm(), c = e.squaredNorm(), f = e.dot(r);
    if (a == 0) return {0, c == 0 ? 0 : std::clamp(f / c, 0.0, 1.0)};
    const double b = d.dot(e), g = d.dot(r), denominator = a * c - b * b;
    if (c == 0) return {std::clamp(-g / a, 0.0, 1.0), 0};
    double s = denominator > 0 ? std::clamp((b * f - g * c) / denominator, 0.0, 1.0) : 0;
    double t = (b * s + f) / c;
    if (t < 0)
        t = 0, s = std::clamp(-g / a, 0.0, 1.0);
    else if (t > 1)
        t = 1, s = std::clamp((b - g) / a, 0.0, 1.0);
    return {s, t};
}

/// True if no point of the surface near a feature's point is nearer to `from`.
bool is_local_minimum(const PlacedSurface& surface, std::uint32_t triangle, std::uint8_t corners, const Vector3d& at,
                      const Vector3d& from)
{
    const Vector3d out = from - at;
    const double tolerance = 1e-9 * out.norm();
    const auto falls = [&](std::uint32_t t) { // a point of the triangle is nearer
        for (const Vector3d& p : surface.points(t))
            if (const double length = (p - at).norm(); length > 0 && out.dot(p - at) > tolerance * length) return true;
        return false;
    };
    if (corners == 7) return true;
    if (falls(triangle)) return false;
    std::uint32_t shared = 0; // the vertex around which triangles are visited
    const auto own = surface.corners(triangle);
    const bool edge = std::popcount(corners) == 2;
    for (int k = 0; k < 3; ++k)
        if (corners >> k & 1) shared = own[k];
    if (edge) {
        for (int k = 0; k < 3; ++k)
            if ((corners >> k & 1) && (corners >> (k + 1) % 3 & 1))
                if (const std::uint32_t t = surface.across(triangle, k); t != PlacedSurface::none && falls(t))
                    return false;
        return true;
    }
    std::uint32_t t = triangle;
    for (int steps = 0; steps < 64; ++steps) {
        const auto v = surface.corners(t);
        const int k = v[0] == shared ? 0 : v[1] == shared ? 1 : 2;
        t = surface.across(t, k);
        if (t == PlacedSurface::none || t == triangle) return true;
        if (falls(t)) return false;
    }
    return true;
}

} // namespace

namespace {

/// Bits of the corners, and of the edges that begin at them, which may be within `reach` of a triangle: by the distance
/// from its plane.
struct InReach {
    unsigned corners = 0, edges = 0;
    /// @param normal  of the triangle `of`, unit; 0 without area
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
        std::uint32_t at;
    };
    std::vector<Key> keys;
    for (const NearPair& p : found) keys.push_back({p.a, p.b, p.distance, static_cast<std::uint32_t>(keys.size())});
    // Pairs were found in the order of their triangles.
    std::ranges::sort(keys, {}, [](const Key& k) { return std::tuple(k.a, k.b, k.distance, k.at); });
    const auto same = [](const Key& x, const Key& y) { return x.a == y.a && x.b == y.b; };
    keys.erase(std::unique(keys.begin(), keys.end(), same), keys.end());
    std::vector<NearPair> sorted;
    sorted.reserve(keys.size());
    for (const Key& k : keys) sorted.push_back(found[k.at]);
    found.swap(sorted);
}

} // namespace

void near_pairs(PairWorker& worker, const PlacedSurface& a, const PlacedSurface& b, const RelativePose& b_to_a,
                double dhat, double rounding, const NearFilter* filter, std::vector<NearPair>& found)
{
    std::vector<TrianglePair>& pairs = worker.pairs;
    a.with_tree([&](auto& tree_a) {
        b.with_tree([&](auto& tree_b) {
            worker.traversal(tree_a, tree_b).all_near(tree_a, tree_b, b_to_a, dhat + rounding, pairs);
        });
    });
    found.clear();
    const double most = dhat + rounding, reach = most * (1 + 0x1p-20) + rounding;
    const auto outward = [](const TrianglePoints& t) {
        return Vector3d((t[1] - t[0]).cross(t[2] - t[0]).stableNormalized());
    };
    for (const auto& [of_a, of_b] : pairs) {
        const TrianglePoints ta = a.points(of_a), tb = b.points(of_b);
        const Vector3d out_a = outward(ta), out_b = outward(tb);
        const InReach near_a(ta, tb, out_b, reach), near_b(tb, ta, out_a, reach);
        if (!near_a.any() || !near_b.any()) continue;
        NearPair pair{};
        pair.triangle_a = of_a, pair.triangle_b = of_b;
        const auto add = [&](std::uint8_t corners_a, const Vector3d& at_a, std::uint8_t corners_b,
                             const Vector3d& at_b) {
            const double distance2 = (at_a - at_b).squaredNorm();
            if (distance2 > most * most * (1 + 0x1p-40)) return;
            pair.corners_a = corners_a, pair.corners_b = corners_b, pair.point_a = at_a, pair.point_b = at_b;
            pair.distance = std::sqrt(distance2);
            if (pair.distance > most || (filter && !filter->keeps(pair, out_a, out_b))) return;
            pair.a = feature(a, of_a, corners_a), pair.b = feature(b, of_b, corners_b);
            found.push_back(pair);
        };
        const auto corners_a = a.corners(of_a), corners_b = b.corners(of_b);
        for (int k = 0; k < 3; ++k) {
            if ((near_a.corners >> k & 1) && (!filter || a.corner_sticks_out(corners_a[k]))) {
                const auto on_b = nearest_on(tb, ta[k]);
                add(1 << k, ta[k], on_b.corners, on_b.at);
            }
            if ((near_b.corners >> k & 1) && (!filter || b.corner_sticks_out(corners_b[k]))) {
                const auto on_a = nearest_on(ta, tb[k]);
                add(on_a.corners, on_a.at, 1 << k, tb[k]);
            }
        }
        for (int i = 0; i < 3; ++i) {
            if (!(near_a.edges >> i & 1) || (filter && !a.edge_sticks_out(of_a, i))) continue;
            for (int k = 0; k < 3; ++k) {
                if (!(near_b.edges >> k & 1) || (filter && !b.edge_sticks_out(of_b, k))) continue;
                const int i2 = (i + 1) % 3, k2 = (k + 1) % 3;
                const Vector3d d = ta[i2] - ta[i], e = tb[k2] - tb[k];
                const auto [s, t] = nearest_of(ta[i], d, tb[k], e);
                const auto spanned = [](int first, int last, double at) {
                    return std::uint8_t(at <= 0 ? 1 << first : at >= 1 ? 1 << last : 1 << first | 1 << last);
                };
                add(spanned(i, i2, s), ta[i] + s * d, spanned(k, k2, t), tb[k] + t * e);
            }
        }
    }
    sort_once(found);
}

void near_features_of(PairWorker& worker, const PairTask& task, double dhat, std::vector<NearFeatures>& found)
{
    const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
    const RelativePose b_to_a(*task.pose_a, *task.pose_b);
    const PlacedSurface a(*task.a, RelativePose(here, here), {}, false), b(*task.b, b_to_a, {}, false);
    const double slack = stretch(*task.pose_a) + stretch(*task.pose_b);
    const double rounding = 4 * rounding_of(a, b) + slack * dhat + a.error() + b.error();
    std::vector<NearPair> near;
    near_pairs(worker, a, b, b_to_a, dhat, rounding, nullptr, near);
    for (const NearPair& p : near)
        found.push_back({p.a, p.b, std::max(p.distance - rounding, 0.0), p.distance + rounding,
                         *task.pose_a * p.point_a, *task.pose_a * p.point_b});
}

namespace {

/// A round solid and another body: along the shortest way between them.
void add_round_near(PairWorker& worker, ManifoldMemory& memory, const PairTask& task, const PlacedSurface& a,
                    const PlacedSurface& b, const ManifoldOptions& options, Manifold& manifold)
{
    const std::vector<NearPair>& near = memory.near;
    const Distance d = tests_for(task).distance(worker, task, 0, options.margin, true);
    if (!(d.lower > 0) || !(d.upper <= options.margin)) return;
    const Eigen::Isometry3d into = task.pose_a->inverse(Eigen::Isometry);
    const Vector3d on_a = into * d.point_a, on_b = into * d.point_b;
    RegionDraft& draft = memory.draft;
    draft.clear();
    draft.rounding = rounding_of(a, b);
    draft.region.kind = RegionKind::near, draft.region.normal = (on_b - on_a).normalized();
    draft.region.normal_error = std::min(std::numbers::pi, 0x1p-10 + 2 * draft.rounding / d.lower);
    draft.region.centre = 0.5 * (on_a + on_b), draft.region.depth_upper = -d.lower + draft.rounding;
    draft.least_depth = -options.margin;
    const bool of_a = a.round();
    const PlacedSurface& round = of_a ? a : b;
    for (const NearPair& p : near) {
        draft.faces_a.emplace_back(p.triangle_a, a.points(p.triangle_a));
        draft.faces_b.emplace_back(p.triangle_b, b.points(p.triangle_b));
    }
    for (auto* faces : {&draft.faces_a, &draft.faces_b}) {
        std::ranges::sort(*faces, {}, [](const auto& f) { return f.first; });
        const auto same = [](const auto& x, const auto& y) { return x.first == y.first; };
        faces->erase(std::unique(faces->begin(), faces->end(), same), faces->end());
    }
    const Vector3d out = of_a ? draft.region.normal : Vector3d(-draft.region.normal);
    std::uint64_t number = 1;
    for (const Vector3d& p : support_points(round.model().convex(), round.rotated_back(out))) {
        const FeatureBits bits = round.vertex(0) | number++;
        draft.candidates.push_back({round.placed(p), of_a ? ManifoldCandidate::of_a : ManifoldCandidate::of_b,
                                    of_a ? bits : 0, of_a ? 0 : bits});
    }
    const auto misses = [&](const ManifoldCandidate& c) {
        return std::ranges::none_of(of_a ? draft.faces_b : draft.faces_a, [&](const auto& f) {
            const TrianglePoints& t = f.second;
            const Vector3d n = (t[1] - t[0]).cross(t[2] - t[0]);
            if (!(out.dot(n) < 0)) return false;
            const Vector3d at = c.at + n.dot(t[0] - c.at) / out.dot(n) * out;
            return n.dot((t[1] - t[0]).cross(at - t[0])) >= 0 && n.dot((t[2] - t[1]).cross(at - t[1])) >= 0 &&
                   n.dot((t[0] - t[2]).cross(at - t[2])) >= 0;
        });
    };
    std::erase_if(draft.candidates, misses);
    if (draft.candidates.empty()) {
        const double gap = (on_b - on_a).norm();
        constexpr FeatureBits whole = FeatureBits{3} << 62;
        draft.candidates.push_back(
            {0.5 * (on_a + on_b), ManifoldCandidate::of_both, whole, whole, -gap, d.upper - d.lower});
    }
    finish(memory, a, b, options, manifold);
    if (manifold.points.empty()) return;
    for (ManifoldPoint& p : std::span(manifold.points).subspan(manifold.regions.back().first))
        if (p.point_a == p.point_b) p.point_a = on_a, p.point_b = on_b;
}

/// The regions' directions, and the pairs along each.
using NearGroups = std::vector<std::pair<Vector3d, std::vector<const NearPair*>>>;

NearGroups groups_of(const std::vector<NearPair>& near, double spread)
{
    NearGroups groups;
    const double least_cosine = std::cos(spread);
    for (const bool faces : {true, false}) // faces first: they define normals best
        for (const NearPair& p : near) {
            if (faces != p.has_face()) continue;
            const Vector3d way = (p.point_b - p.point_a) / p.distance;
            auto at = std::ranges::find_if(groups, [&](const auto& g) { return g.first.dot(way) >= least_cosine; });
            if (at == groups.end()) groups.push_back({way, {}}), at = groups.end() - 1;
            at->second.push_back(&p);
        }
    return groups;
}

} // namespace

void add_near_regions(PairWorker& worker, ManifoldMemory& memory, const PairTask& task, const PlacedSurface& a,
                      const PlacedSurface& b, const RelativePose& b_to_a, const ManifoldOptions& options,
                      Manifold& manifold)
{
    const double rounding = 4 * rounding_of(a, b);
    std::vector<NearPair>& near = memory.near;
    const bool round = a.round() || b.round();
    const NearFilter filter{round ? -1 : rounding};
    near_pairs(worker, a, b, b_to_a, options.margin, rounding, &filter, near);
    if (round) return add_round_near(worker, memory, task, a, b, options, manifold);
    std::erase_if(near, [&](const NearPair& p) {
        return !is_local_minimum(a, p.triangle_a, p.corners_a, p.point_a, p.point_b) ||
               !is_local_minimum(b, p.triangle_b, p.corners_b, p.point_b, p.point_a);
    });
    constexpr double most_spread = std::numbers::pi / 3;
    const std::size_t most = most_regions(options),
                      room = most > manifold.regions.size() ? most - manifold.regions.size() : 1;
    double spread = options.normal_spread;
    NearGroups groups = groups_of(near, spread);
    while (groups.size() > room && spread < most_spread) // more directions than regions
        spread = std::min(1.5 * std::max(spread, 0.05), most_spread), groups = groups_of(near, spread);
    for (const auto& [first, members] : groups) {
        RegionDraft& draft = memory.draft;
        draft.clear();
        draft.rounding = rounding;
        ManifoldRegion& region = draft.region;
        region.kind = RegionKind::near, region.open = !a.solid() || !b.solid();
        const bool faces = members.front()->has_face();
        Vector3d sum = Vector3d::Zero();
        for (const NearPair* p : members)
            if (p->has_face() == faces) sum += (p->point_b - p->point_a).normalized();
        region.normal = sum.norm() > 0.1 ? Vector3d(sum.normalized()) : first;
        Aabb box;
        double least = options.margin;
        for (const NearPair* p : members) {
            region.normal_error = std::max(region.normal_error, angle_between(p->point_b - p->point_a, region.normal) +
                                                                    0x1p-40 + rounding / p->distance);
            const Vector3d middle = 0.5 * (p->point_a + p->point_b);
            const double depth = region.normal.dot(p->point_a - p->point_b);
            box.add(middle), least = std::min(least, -depth);
            const double aside = (p->point_b - p->point_a + depth * region.normal).norm();
            draft.candidates.push_back({middle, ManifoldCandidate::of_both, p->a, p->b, depth, aside, true,
                                        (p->point_b - p->point_a) / p->distance});
        }
        region.centre = box.centre(), region.depth_upper = -least + 2 * rounding;
        finish(memory, a, b, options, manifold);
        for (ManifoldPoint& p : std::span(manifold.points).subspan(manifold.regions.back().first)) {
            p.point_a += 0.5 * p.depth * region.normal, p.point_b -= 0.5 * p.depth * region.normal;
        }
    }
}

} // namespace oncollide
