#include <oncollide/narrowphase/pairs/manifolds/near_regions.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <oncollide/narrowphase/exact/triangle_gap.hpp>

namespace oncollide {

using Eigen::Vector3d;

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

/// Moves the points of the last region from the middle onto both bodies.
void move_onto_bodies(const ManifoldJob& job)
{
    const ManifoldRegion& region = job.manifold.regions.back();
    for (ManifoldPoint& p : std::span(job.manifold.points).subspan(region.first))
        p.point_a += 0.5 * p.depth * region.normal, p.point_b -= 0.5 * p.depth * region.normal;
}

} // namespace

/// A region of the nearest two triangles, where no pair of features is certainly a minimum: slivers, and triangles that
/// are so near that rounding hides their direction. Exact integers then find a direction.
void NearRegions::add_nearest(const ManifoldJob& job, RegionMaker& maker) const
{
    const PlacedSurface &a = job.a, &b = job.b;
    const double rounding = near_rounding(a, b);
    NearestPoints nearest{{}, {}, std::numeric_limits<double>::infinity()};
    const TrianglePair* found = nullptr;
    for (const TrianglePair& pair : triangles) {
        const NearestPoints points = nearest_points(a.points(pair.a), b.points(pair.b), 0.5 * rounding);
        if (points.distance < nearest.distance) nearest = points, found = &pair;
    }
    const bool hidden = nearest.distance <= 2 * rounding;
    if (!(nearest.distance <= job.options.margin + rounding) || !(hidden || job.solid())) return;
    RegionDraft& draft = maker.draft;
    draft.begin(RegionKind::near, !job.solid(), rounding);
    ManifoldRegion& region = draft.region;
    region.normal = (nearest.b - nearest.a).normalized();
    if (hidden) triangle_gap(a.points(found->a), b.points(found->b), &region.normal);
    if (region.normal.isZero(0)) region.normal = Vector3d::UnitZ();
    region.normal_error = hidden ? std::numbers::pi : 0x1p-40 + rounding / nearest.distance;
    region.centre = 0.5 * (nearest.a + nearest.b), region.depth_upper = 2 * rounding - nearest.distance;
    draft.candidates.push_back({region.centre, ManifoldCandidate::of_both, a.face(found->a), b.face(found->b),
                                -nearest.distance, 2 * rounding, true, region.normal});
    maker.finish(job), move_onto_bodies(job);
}

void NearRegions::add(const ManifoldJob& job, bool meets, RegionMaker& maker)
{
    const double rounding = near_rounding(job.a, job.b), margin = job.options.margin;
    search_.find(job.a, job.b, triangles, margin, rounding, NearSearch::Which::minima, near_);
    std::vector<ManifoldRegion>& regions = job.manifold.regions;
    const std::size_t begin = regions.size(), most = job.most_regions(), room = most > begin ? most - begin : 1;
    using manifold_limits::most_spread;
    double spread = job.options.normal_spread;
    NearGroups groups = groups_of(near_, spread);
    while (groups.size() > room && spread < most_spread) { // more directions than regions
        spread = std::min(manifold_limits::widening * std::max(spread, manifold_limits::least_widened), most_spread);
        groups = groups_of(near_, spread);
    }
    for (const auto& [first, members] : groups) {
        RegionDraft& draft = maker.draft;
        draft.begin(RegionKind::near, !job.solid(), rounding);
        ManifoldRegion& region = draft.region;
        const bool faces = members.front()->has_face();
        Vector3d sum = Vector3d::Zero();
        for (const NearPair* p : members)
            if (p->has_face() == faces) sum += (p->point_b - p->point_a).normalized();
        region.normal = sum.norm() > manifold_limits::least_near_direction ? Vector3d(sum.normalized()) : first;
        Aabb box;
        double least = margin;
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
        maker.finish(job), move_onto_bodies(job);
    }
    // Where edges are nearly parallel, a certain minimum may be not quite the least.
    const auto nearest = std::ranges::max_element(regions.begin() + std::ptrdiff_t(begin), regions.end(), {},
                                                  &ManifoldRegion::depth_upper);
    if (nearest != regions.end()) nearest->depth_upper = std::max(nearest->depth_upper, 2 * rounding - search_.least());
    if (regions.empty() && !meets) add_nearest(job, maker);
}

} // namespace oncollide
