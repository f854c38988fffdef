#include <oncollide/narrowphase/pairs/manifolds/region_maker.hpp>

#include <algorithm>
#include <cmath>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/point_hull.hpp>
#include <oncollide/narrowphase/rays/segment_entry.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

/// Estimates depths as if the surfaces were flat near their common curve.
void estimate_depths(std::vector<ManifoldCandidate>& all, const Vector3d& n)
{
    double height = 0, points = 0;
    for (const ManifoldCandidate& c : all)
        if (c.of == ManifoldCandidate::of_both) height += n.dot(c.at), ++points;
    for (ManifoldCandidate& c : all)
        if (c.of != ManifoldCandidate::of_both && points > 0)
            c.depth = (c.of == ManifoldCandidate::of_a ? 1 : -1) * (n.dot(c.at) - height / points);
}

/// Gives all points of a flat region its normal: solvers do not bring a body to rest between normals that differ a
/// little.
void level(std::span<ManifoldPoint> points, const Vector3d& normal)
{
    const auto level = [&](const ManifoldPoint& p) {
        return p.normal.cross(normal).norm() <= manifold_limits::level_angle;
    };
    if (std::ranges::all_of(points, level))
        for (ManifoldPoint& p : points) p.normal = normal;
}

} // namespace

/// Finds whether the region is curved. Drops candidates that face nothing, or are too shallow, if others are left.
/// @param resolved  the candidates have their opposite faces
void RegionMaker::drop_idle(bool resolved)
{
    using manifold_limits::facing_cosine;
    auto& all = draft.candidates;
    if (std::ranges::any_of(all, &ManifoldCandidate::opposite))
        std::erase_if(all, [](const auto& c) { return !c.opposite; });
    const auto known = [](const ManifoldCandidate& c) { return !c.normal.isZero(0); };
    const auto differs = [&](const ManifoldCandidate& c) {
        const double cosine = c.normal.dot(draft.region.normal);
        return known(c) && cosine < manifold_limits::curved_cosine &&
               (resolved || c.of == ManifoldCandidate::of_both || cosine > facing_cosine);
    };
    curved_ = std::ranges::any_of(all, differs);
    const auto faces = [&](const ManifoldCandidate& c) { return c.normal.dot(draft.region.normal) >= facing_cosine; };
    if (curved_ && std::ranges::any_of(all, faces)) std::erase_if(all, [&](const auto& c) { return !faces(c); });
    const auto deep = [&](const ManifoldCandidate& c) { return c.depth >= draft.least_depth; };
    if (std::ranges::any_of(all, deep)) std::erase_if(all, [&](const auto& c) { return !deep(c); });
}

/// Finds the face opposite to a candidate along the region's normal, and with it the depth and the point's normal.
/// @param all_angles  faces at large angles count as opposite, too
void RegionMaker::resolve(const ManifoldJob& job, bool all_angles, ManifoldCandidate& c)
{
    if (c.of == ManifoldCandidate::of_both || (c.a && c.b)) return;
    const bool of_a = c.of == ManifoldCandidate::of_a;
    const int other = of_a ? 1 : 0;
    double depth, beside_by;
    if (const auto* found = ahead_[other].nearest(c.at, depth, beside_by)) {
        c.depth = depth, c.error = draft.rounding * found->error + beside_by;
        const Vector3d across = (of_a ? 1 : -1) * found->depth.normalized(); // normal of the face, from a to b
        c.normal = of_a ? normal_across(c.normal, across) : normal_across(across, c.normal);
        if (all_angles && c.normal.isZero(0)) c.normal = across;
        (of_a ? c.b : c.a) = job.surface(other).face(found->triangle);
    } else { // treats the point as at the end of a region
        const double behind = job.surface(other).behind(c.at, (of_a ? -1 : 1) * draft.region.normal);
        c.depth = 0, c.error = std::max(draft.region.depth_upper, behind) + draft.rounding, c.opposite = false;
        if (c.normal.dot(draft.region.normal) < manifold_limits::facing_cosine) c.normal.setZero();
    }
}

/// The candidates to keep. On a curved region, drops candidates found to face nothing, and chooses again.
std::span<const std::uint32_t> RegionMaker::choose_resolved(const ManifoldJob& job)
{
    auto& all = draft.candidates;
    for (;;) {
        const auto& kept = choice_.choose(all, draft.region.normal, job.most_points());
        for (const std::uint32_t i : kept) resolve(job, !curved_, all[i]);
        const auto idle = [](const ManifoldCandidate& c) { return !c.opposite || c.normal.isZero(0); };
        if (!curved_ || std::ranges::none_of(kept, [&](std::uint32_t i) { return idle(all[i]); }) ||
            std::ranges::all_of(all, idle))
            return kept;
        std::erase_if(all, idle);
    }
}

/// A lower bound of the way along a direction from a point inside a surface to the surface; at most `most`. The faces
/// of a region do not suffice: the way may leave the overlap, and then the body through a face that is not in the
/// region.
double RegionMaker::way_out(const PlacedSurface& surface, const Vector3d& from, const Vector3d& along, double most)
{
    const Segment way{surface.placed_back(from), surface.placed_back(from + most * along)};
    double least = 1;
    const auto take = [&](const TrianglePoints& face) {
        if (const auto entry = entry_of(way, face)) least = std::min(least, entry->lower);
        return least;
    };
    surface.with_tree([&](auto& tree) {
        if constexpr (requires { tree.corners(0); })
            ways_out_.walk(tree, way, [&](std::uint32_t triangle) { return take(tree.corners(triangle)); });
        else
            ways_out_of_terrain_.walk(tree, way, [&](std::uint32_t triangle) { return take(tree.points(triangle)); });
    });
    return least * most;
}

/// The point of a chosen candidate. Raises the bounds of the region's depth.
ManifoldPoint RegionMaker::point_of(const ManifoldJob& job, const ManifoldCandidate& c)
{
    ManifoldRegion& region = draft.region;
    const Vector3d n = region.normal;
    const bool of_a = c.of == ManifoldCandidate::of_a, of_b = c.of == ManifoldCandidate::of_b;
    const double off = job.a.error() + job.b.error();
    const Vector3d normal = c.normal.dot(n) >= manifold_limits::point_cosine ? c.normal : n;
    ManifoldPoint p{c.at, c.at, c.depth, c.error + draft.rounding + off, c.a, c.b, normal};
    double deep = p.depth - p.depth_error;
    if (const PlacedSurface& other = of_a ? job.b : job.a;
        deep > std::max(region.depth_lower, 0.0) && other.solid() && (of_a || of_b)) {
        const double out = way_out(other, c.at, (of_a ? -1 : 1) * n, deep);
        if (curved_ && out < manifold_limits::through_share * deep) p.depth = out;
        deep = out - draft.rounding;
    }
    if (of_a) p.point_b = c.at - p.depth * n;
    if (of_b) p.point_a = c.at + p.depth * n;
    region.depth_upper = std::max(region.depth_upper, p.depth - p.depth_error);
    region.depth_lower = std::max(region.depth_lower, deep);
    return p;
}

void RegionMaker::finish(const ManifoldJob& job)
{
    ManifoldRegion& region = draft.region;
    auto& all = draft.candidates;
    ONCOLLIDE_ASSERT(!all.empty());
    ahead_[0].set(draft.faces[0], region.normal), ahead_[1].set(draft.faces[1], -region.normal);
    const bool early = all.size() * (draft.faces[0].size() + draft.faces[1].size()) <= manifold_limits::most_rays;
    if (early)
        for (ManifoldCandidate& c : all) resolve(job, false, c);
    drop_idle(early);
    if (!early) estimate_depths(all, region.normal);
    std::vector<ManifoldPoint>& points = job.manifold.points;
    region.first = static_cast<std::uint32_t>(points.size());
    region.found = static_cast<std::uint32_t>(all.size());
    region.depth_lower = -unbounded;
    for (const std::uint32_t i : early ? choice_.choose(all, region.normal, job.most_points()) : choose_resolved(job))
        points.push_back(point_of(job, all[i]));
    region.count = static_cast<std::uint32_t>(points.size()) - region.first;
    if (region.kind != RegionKind::near) region.depth_lower = std::max(region.depth_lower, 0.0);
    region.depth_upper = std::max(region.depth_upper, region.depth_lower);
    const auto own = std::span(points).subspan(region.first);
    level(own, region.normal);
    if (job.options.measures) {
        const PointHull hull(own);
        double lost = 0;
        for (const Vector3d& p : draft.contacts) lost = std::max(lost, hull.distance2(p, lost));
        region.lost = std::sqrt(lost) + draft.rounding;
    }
    job.manifold.regions.push_back(region);
}

} // namespace oncollide
