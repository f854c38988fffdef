// Regions of surfaces that are near each other.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <oncollide/narrowphase/exact/triangle_gap.hpp>
#include <oncollide/narrowphase/pairs/manifolds/near_pairs.hpp>
#include <oncollide/narrowphase/pairs/manifolds/region_draft.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>

namespace oncollide {

using Eigen::Vector3d;

void add_round_near(PairWorker& worker, ManifoldMemory& memory, const PairTask& task, const PlacedSurface& a,
                    const PlacedSurface& b, const RelativePose& b_to_a, const ManifoldOptions& options,
                    Manifold& manifold)
{
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
    const PlacedSurface &round = of_a ? a : b, &other = of_a ? b : a;
    auto& faces = of_a ? draft.faces_b : draft.faces_a;
    a.with_tree([&](auto& tree_a) {
        b.with_tree([&](auto& tree_b) {
            worker.traversal(tree_a, tree_b)
                .all_near(tree_a, tree_b, b_to_a, options.margin + near_rounding(a, b), memory.near_triangles);
        });
    });
    memory.vertices.clear();
    for (const TrianglePair& pair : memory.near_triangles) {
        bool is_new;
        const std::uint32_t t = of_a ? pair.b : pair.a;
        if (memory.vertices.add(t, is_new), is_new) faces.emplace_back(t, other.points(t));
    }
    std::ranges::sort(faces, {}, [](const auto& f) { return f.first; });
    const Vector3d out = of_a ? draft.region.normal : Vector3d(-draft.region.normal);
    std::uint64_t number = 1;
    for (const Vector3d& p : support_points(round.model().convex(), round.rotated_back(out))) {
        const FeatureBits bits = round.vertex(0) | number++;
        draft.candidates.push_back({round.placed(p), of_a ? ManifoldCandidate::of_a : ManifoldCandidate::of_b,
                                    of_a ? bits : 0, of_a ? 0 : bits});
    }
    const auto misses = [&](const ManifoldCandidate& c) {
        return std::ranges::none_of(faces, [&](const auto& f) {
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

namespace {

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

/// A region of the nearest two triangles, where no pair of features is certainly a minimum: slivers, and triangles that
/// are so near that rounding hides their direction. Integers find one then.
void add_nearest_region(ManifoldMemory& memory, const PlacedSurface& a, const PlacedSurface& b,
                        const ManifoldOptions& options, double rounding, Manifold& manifold)
{
    NearestPoints nearest{{}, {}, std::numeric_limits<double>::infinity()};
    const TrianglePair* found = nullptr;
    for (const TrianglePair& pair : memory.near_triangles) {
        const NearestPoints points = nearest_points(a.points(pair.a), b.points(pair.b), 0.5 * rounding);
        if (points.distance < nearest.distance) nearest = points, found = &pair;
    }
    const bool hidden = nearest.distance <= 2 * rounding, solid = a.solid() && b.solid();
    if (!(nearest.distance <= options.margin + rounding) || !(hidden || solid)) return;
    RegionDraft& draft = memory.draft;
    draft.clear();
    draft.rounding = rounding;
    ManifoldRegion& region = draft.region;
    region.kind = RegionKind::near, region.open = !a.solid() || !b.solid();
    region.normal = (nearest.b - nearest.a).normalized();
    if (hidden) triangle_gap(a.points(found->a), b.points(found->b), &region.normal);
    if (region.normal.isZero(0)) region.normal = Vector3d::UnitZ();
    region.normal_error = hidden ? std::numbers::pi : 0x1p-40 + rounding / nearest.distance;
    region.centre = 0.5 * (nearest.a + nearest.b), region.depth_upper = 2 * rounding - nearest.distance;
    draft.candidates.push_back({region.centre, ManifoldCandidate::of_both, a.face(found->a), b.face(found->b),
                                -nearest.distance, 2 * rounding, true, region.normal});
    finish(memory, a, b, options, manifold);
}

} // namespace

void add_near_regions(ManifoldMemory& memory, const PlacedSurface& a, const PlacedSurface& b,
                      const ManifoldOptions& options, Manifold& manifold)
{
    const double rounding = near_rounding(a, b);
    std::vector<NearPair>& near = memory.near;
    memory.near_search.find(a, b, memory.near_triangles, options.margin, rounding, NearSearch::Which::minima, near);
    constexpr double most_spread = std::numbers::pi / 3;
    const std::size_t most = most_regions(options),
                      room = most > manifold.regions.size() ? most - manifold.regions.size() : 1;
    double spread = options.normal_spread;
    NearGroups groups = groups_of(near, spread);
    while (groups.size() > room && spread < most_spread) // more directions than regions
        spread = std::min(1.5 * std::max(spread, 0.05), most_spread), groups = groups_of(near, spread);
    const std::size_t begin = manifold.regions.size();
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
    // Where edges are nearly parallel, a minimum may be certain that is not quite the least.
    const auto nearest = std::ranges::max_element(manifold.regions.begin() + std::ptrdiff_t(begin),
                                                  manifold.regions.end(), {}, &ManifoldRegion::depth_upper);
    if (nearest != manifold.regions.end())
        nearest->depth_upper = std::max(nearest->depth_upper, 2 * rounding - memory.near_search.least());
    if (manifold.regions.empty() && memory.meeting.empty())
        add_nearest_region(memory, a, b, options, rounding, manifold);
}

} // namespace oncollide
