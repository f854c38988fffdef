// The manifold of two bodies of any kinds.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/pairs/depth/depth_steps.hpp>
#include <oncollide/narrowphase/pairs/manifold_tests.hpp>
#include <oncollide/narrowphase/pairs/manifolds/convex_on_surface.hpp>
#include <oncollide/narrowphase/pairs/manifolds/crossing_regions.hpp>
#include <oncollide/narrowphase/pairs/manifolds/near_regions.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/feature_bits.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/point_hull.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/shape_manifold.hpp>
#include <oncollide/narrowphase/pairs/manifolds/touching_regions.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>

namespace oncollide {

using Eigen::Vector3d;

/// One thread's working memory, kept from pair to pair.
struct ManifoldMemory {
    std::vector<TrianglePair> meeting; ///< all pairs of triangles that meet
    OverlapPatches overlap;
    CrossingRegions crossing;
    TouchingRegions touching;
    NearRegions near;
    RegionMaker maker;
    ConvexOnSurface convex;
};

namespace {

/// True if the computation takes b first: a half-space is first; otherwise the order of the exact level counts.
bool takes_b_first(const PairTask& task)
{
    const bool plane_a = task.a->kind() == Kind::half_space, plane_b = task.b->kind() == Kind::half_space;
    if (plane_a != plane_b) return plane_b;
    if (decides_b_first(task)) return true;
    return !decides_b_first(task.swapped()) && task.b->number() < task.a->number();
}

/// True if a part of the inner body is inside the outer one.
/// @param deep  metres: all around the part's point, points at this distance are inside, too
bool is_held(const PlacedSurface& inner, const PlacedSurface& outer, PointLocator& locator, double deep)
{
    const auto holds = [&](const Vector3d& p) { return outer.holds(p, locator).value_or(false); };
    const auto holds_deep = [&](const Vector3d& p) {
        for (int k = 0; k < 3; ++k)
            if (!holds(p + deep * Vector3d::Unit(k)) || !holds(p - deep * Vector3d::Unit(k))) return false;
        return true;
    };
    return outer.solid() &&
           inner.any_part_point([&](const Vector3d& p) { return holds(p) && (deep == 0 || holds_deep(p)); });
}

/// The body of which a part is inside the other one: the smaller one, if both have such a part. Null: none.
const PlacedSurface* held_of(const PlacedSurface& a, const PlacedSurface& b, PointLocator& locator, double deep)
{
    const bool a_first = a.extent() <= b.extent();
    const PlacedSurface &first = a_first ? a : b, &second = a_first ? b : a;
    return is_held(first, second, locator, deep) ? &first : is_held(second, first, locator, deep) ? &second : nullptr;
}

/// The body inside moves out through the nearest surface.
void add_enclosed_region(PairWorker& worker, const ManifoldJob& job, bool inner_is_a, const RelativePose& b_to_a)
{
    const PlacedSurface &a = job.a, &b = job.b;
    Manifold& manifold = job.manifold;
    const PlacedSurface &inner = inner_is_a ? a : b, &outer = inner_is_a ? b : a;
    double gap = 0;
    Vector3d way = Vector3d::Zero(); // direction in which the inner body moves
    std::optional<NearestPoints> nearest;
    a.with_tree([&](auto& tree_a) {
        b.with_tree([&](auto& tree_b) {
            const auto found = worker.traversal(tree_a, tree_b).distance(tree_a, tree_b, b_to_a, 0);
            if (!found.nearest) return;
            gap = std::max(found.lower, 0.0);
            const TrianglePoints of_a = a.points(found.nearest->a), of_b = b.points(found.nearest->b);
            const TrianglePoints& wall = inner_is_a ? of_b : of_a;
            const NearestPoints& points = nearest.emplace(nearest_points(of_a, of_b, 0x1p-20 * gap + job.rounding));
            way = inner_is_a ? Vector3d(points.b - points.a) : Vector3d(points.a - points.b);
            if (gap == 0 || way.norm() <= job.rounding) way = (wall[1] - wall[0]).cross(wall[2] - wall[0]);
        });
    });
    way = way.norm() > 0 ? Vector3d(way.normalized()) : Vector3d::UnitZ();
    ManifoldRegion region{};
    region.kind = RegionKind::enclosed;
    region.normal = inner_is_a ? Vector3d(-way) : way;
    const double rounding = job.rounding + a.error() + b.error();
    region.normal_error = gap > rounding ? std::min(std::numbers::pi, 0x1p-20 + rounding / gap) : 0x1p-20;
    region.open = !inner.solid();
    const Vector3d last = inner.farthest(-way), first = outer.farthest(way);
    const double last_along = way.dot(last);
    // The distance to the plane through the nearest point of the wall.
    const double to_wall = way.dot(inner.farthest(way)) + gap - last_along;
    const Vector3d wall_point = last + to_wall * way;
    region.depth_upper = std::max(way.dot(first) - last_along, to_wall) + 4 * rounding;
    region.depth_lower = std::max(gap - rounding, 0.0);
    region.first = static_cast<std::uint32_t>(manifold.points.size()), region.count = region.found = 1;
    region.centre = 0.5 * (last + wall_point);
    double error = std::max(to_wall - region.depth_lower, region.depth_upper - to_wall);
    if (nearest) { // the surfaces are at least as near as at these points
        const Vector3d &at_wall = inner_is_a ? nearest->b : nearest->a,
                       &of_inner = inner_is_a ? nearest->a : nearest->b;
        error = std::max(error, (wall_point - at_wall).norm());
        const Kind kind = inner.model().kind();
        if (kind == Kind::terrain || kind == Kind::map) // their farthest point may be a corner of their AABB
            error = std::max(error, (last - of_inner).norm());
    }
    constexpr FeatureBits whole = face_feature(0);
    manifold.points.push_back(inner_is_a
                                  ? ManifoldPoint{last, wall_point, to_wall, error, whole, whole, region.normal}
                                  : ManifoldPoint{wall_point, last, to_wall, error, whole, whole, region.normal});
    manifold.regions.push_back(region);
}

/// A region where none was found although the bodies are not certainly apart, or are within the margin: cells without
/// an open side, gaps that rounding hides.
void add_last_region(PairWorker& worker, const PairTask& task, const ManifoldJob& job)
{
    const PlacedSurface &a = job.a, &b = job.b;
    const Eigen::Isometry3d into = task.pose_a->inverse(Eigen::Isometry);
    const bool apart = decide_both_orders(worker, task).verdict == Verdict::separate;
    if (apart && job.options.margin == 0) return;
    const double cutoff = job.options.margin + 64 * job.rounding; // also finds gaps that rounding hides
    const Distance found = tests_for(task).distance(worker, task, {.cutoff = cutoff}, true);
    if (apart && !(found.upper <= job.options.margin)) return;
    ManifoldRegion region{};
    region.kind = apart ? RegionKind::near : RegionKind::touching;
    Vector3d on_a = into * found.point_a, on_b = into * found.point_b;
    region.normal = on_b - on_a, region.normal_error = std::numbers::pi;
    if (apart && region.normal.norm() > 4 * job.rounding) {
        region.normal_error = std::min(std::numbers::pi, 0x1p-10 + 2 * job.rounding / found.upper);
    } else {
        std::vector<Contact> contacts;
        tests_for(task).contacts(worker, task, contacts);
        region.normal.setZero();
        if (!contacts.empty()) {
            on_a = into * contacts[0].ends[0], on_b = into * contacts[0].ends[1];
            region.normal = into.linear() * (contacts[0].normal_a - contacts[0].normal_b);
        }
    }
    region.normal = region.normal.norm() > 0 ? Vector3d(region.normal.normalized()) : Vector3d::UnitZ();
    const double width = region.normal.dot(a.farthest(region.normal) - b.farthest(-region.normal));
    const double rounding = 4 * job.rounding + a.error() + b.error();
    region.depth_lower = apart ? -found.upper - rounding : 0;
    region.depth_upper =
        apart ? std::max(-found.lower, region.depth_lower) + rounding : std::max(width, 0.0) + rounding;
    region.first = static_cast<std::uint32_t>(job.manifold.points.size()), region.count = region.found = 1;
    region.centre = 0.5 * (on_a + on_b), region.lost = apart ? 0 : std::numeric_limits<double>::infinity();
    const double depth = region.normal.dot(on_a - on_b);
    constexpr FeatureBits whole = face_feature(0);
    double error = (on_a - on_b).norm() + rounding;
    if (!apart) error += std::max(a.behind(on_a, region.normal), b.behind(on_b, -region.normal));
    job.manifold.points.push_back({on_a, on_a - depth * region.normal, depth, error, whole, whole, region.normal});
    job.manifold.regions.push_back(region);
}

/// Drops a point that an earlier region has, too, with nearly the same normal: a solver would get the same equation
/// twice. A region keeps at least one point.
void drop_repeated(Manifold& manifold, const ManifoldOptions& options)
{
    std::vector<ManifoldPoint> kept;
    std::vector<double> same; // distance within which two points count as the same
    for (ManifoldRegion& r : manifold.regions) {
        const auto own = std::span<const ManifoldPoint>(manifold.points).subspan(r.first, r.count);
        const std::size_t before = kept.size();
        const double near = manifold_limits::repeated_share * std::sqrt(r.area);
        for (const ManifoldPoint& p : own) {
            std::size_t i = 0;
            while (i < before && !(kept[i].normal.dot(p.normal) > manifold_limits::repeated_cosine &&
                                   ((kept[i].feature_a == p.feature_a && kept[i].feature_b == p.feature_b) ||
                                    (middle_of(kept[i]) - middle_of(p)).norm() < std::min(near, same[i]))))
                ++i;
            if (i == before || (&p == &own.back() && kept.size() == before)) kept.push_back(p), same.push_back(near);
        }
        r.first = static_cast<std::uint32_t>(before), r.count = static_cast<std::uint32_t>(kept.size() - before);
        if (r.count < own.size() && options.measures)
            r.lost += most_lost(std::span<const ManifoldPoint>(kept).subspan(before), own);
    }
    manifold.points = std::move(kept);
}

/// Sorts the regions, keeps the deepest, and moves all to the world.
void complete(Manifold& manifold, const ManifoldOptions& options, const Eigen::Isometry3d& pose)
{
    std::vector<ManifoldRegion>& regions = manifold.regions;
    std::ranges::stable_sort(regions, std::ranges::greater{}, [](const ManifoldRegion& r) { return r.depth_lower; });
    if (const std::size_t most = std::max(options.regions_per_pair, 1u); regions.size() > most)
        regions.resize(most), manifold.complete = false;
    drop_repeated(manifold, options);
    for (ManifoldRegion& r : regions) r.normal = (pose.linear() * r.normal).normalized(), r.centre = pose * r.centre;
    for (ManifoldPoint& p : manifold.points)
        p.point_a = pose * p.point_a, p.point_b = pose * p.point_b, p.normal = (pose.linear() * p.normal).normalized();
    limit_points(manifold, options.points_per_pair);
}

/// @param joins  see PlacedSurface
void find(PairWorker& worker, const PairTask& task, const ManifoldOptions& options, Manifold& manifold, bool joins)
{
    const Kind kind_a = task.a->kind(), kind_b = task.b->kind();
    const bool round = kind_a == Kind::round || kind_b == Kind::round;
    // The measures of a box or a hull are found from both surfaces.
    const bool convex = round || (!options.measures && ConvexOnSurface::takes(task));
    const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
    const RelativePose b_to_a(*task.pose_a, *task.pose_b);
    const auto box_in = [&](const Model& of, const Model& other, const Eigen::Isometry3d& from,
                            const Eigen::Isometry3d& to) {
        if (of.kind() != Kind::map && of.kind() != Kind::half_space) return Aabb{}; // they need none
        const RelativePose into(to, from); // far from the origin, a product of poses would be rounded too much
        Eigen::Isometry3d pose(Eigen::Translation3d(into.translation));
        pose.linear() = into.rotation;
        Aabb box = other.bounds().box(pose);
        const double more = options.margin + 0x1p-40 * (box.diagonal() + box.centre().norm());
        box.min.array() -= more, box.max.array() += more;
        return box;
    };
    const PlacedSurface a(*task.a, RelativePose(here, here), box_in(*task.a, *task.b, *task.pose_b, *task.pose_a),
                          joins);
    const PlacedSurface b(*task.b, b_to_a, box_in(*task.b, *task.a, *task.pose_a, *task.pose_b), joins);
    if (!worker.manifold_memory) worker.manifold_memory = std::make_shared<ManifoldMemory>();
    ManifoldMemory& memory = *worker.manifold_memory;
    const ManifoldJob job{a, b, options, manifold};
    if (a.empty() || b.empty()) return add_last_region(worker, task, job);
    const bool made = convex && memory.convex.add(worker, task, job, b_to_a);
    if (!made) {
        a.with_tree([&](auto& tree_a) {
            b.with_tree([&](auto& tree_b) {
                auto& traversal = worker.traversal(tree_a, tree_b);
                if (options.margin > 0)
                    traversal.all_near(tree_a, tree_b, b_to_a, options.margin + near_rounding(a, b),
                                       memory.near.triangles, &memory.meeting);
                else
                    traversal.all_meeting(tree_a, tree_b, b_to_a, memory.meeting);
            });
        });
        if (!memory.meeting.empty()) {
            memory.overlap.find(a, b, memory.meeting, worker.locator);
            memory.crossing.add(job, memory.overlap, memory.maker);
            memory.touching.add(job, memory.meeting, memory.overlap, memory.maker);
        }
    }
    const auto overlaps = [](const ManifoldRegion& r) {
        return r.kind == RegionKind::crossing || r.kind == RegionKind::enclosed;
    };
    if (std::ranges::none_of(manifold.regions, overlaps)) {
        // Where they touch, a corner may be as deep.
        double deep = manifold.regions.empty() ? 0 : 16 * job.rounding;
        for (const ManifoldRegion& r : manifold.regions) deep = std::max(deep, 2 * r.depth_upper);
        if (const PlacedSurface* held = held_of(a, b, worker.locator, deep)) {
            for (ManifoldRegion& r : manifold.regions)
                // The body touches from inside.
                r.normal_error = std::numbers::pi;
            add_enclosed_region(worker, job, held == &a, b_to_a);
        }
    }
    if (options.margin > 0 && !made) memory.near.add(job, !memory.meeting.empty(), memory.maker);
    // A joined face is flat; its original triangles, moved with rounding, may stick out of it by the rounding.
    if (!manifold.regions.empty()) return;
    if (a.joined() || b.joined()) {
        const Finding found = decide_both_orders(worker, task);
        if (found.verdict != Verdict::separate || found.bound <= options.margin)
            find(worker, task, options, manifold, false);
    } else {
        add_last_region(worker, task, job);
    }
}

void drop_measures(Manifold& manifold)
{
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    for (ManifoldRegion& r : manifold.regions) r.area = r.volume = r.lost = none, r.centre.setConstant(none);
}

} // namespace

bool needs_trees(const PairTask& task)
{
    return !are_shapes(takes_b_first(task) ? task.swapped() : task);
}

bool may_be_enclosed(const PairTask& task)
{
    const auto holds = [](Model& outer, const Eigen::Isometry3d& pose, Model& inner,
                          const Eigen::Isometry3d& of_inner) {
        if (outer.kind() == Kind::mesh) {
            const Aabb around = outer.bounds().box(pose), box = inner.bounds().box(of_inner);
            return (box.min.array() >= around.min.array()).all() && (box.max.array() <= around.max.array()).all() &&
                   outer.closed();
        }
        if (outer.kind() != Kind::terrain || inner.kind() == Kind::half_space) return false;
        const RelativePose into(pose, of_inner);
        const auto below = [&](const Vector3d& p) {
            return depth_bounds::is_below(*outer.terrain(), outer.heights(), into(p), 0);
        };
        if (inner.map() || inner.cooked()) return true; // their points are not at hand
        return std::ranges::any_of(inner.parts(), [&](const PartPoints& p) { return std::ranges::any_of(p, below); });
    };
    return holds(*task.a, *task.pose_a, *task.b, *task.pose_b) || holds(*task.b, *task.pose_b, *task.a, *task.pose_a);
}

void manifold_of(PairWorker& worker, const PairTask& task, const ManifoldOptions& options, Manifold& manifold)
{
    const bool swapped = takes_b_first(task);
    const PairTask ordered = swapped ? task.swapped() : task;
    if (are_shapes(ordered)) {
        manifold_of_shapes(worker, ordered, options, manifold);
    } else {
        find(worker, ordered, options, manifold, true);
        complete(manifold, options, *ordered.pose_a);
    }
    if (!options.measures) drop_measures(manifold);
    if (!swapped) return;
    for (ManifoldRegion& r : manifold.regions) r.normal = -r.normal;
    for (ManifoldPoint& p : manifold.points)
        std::swap(p.point_a, p.point_b), std::swap(p.feature_a, p.feature_b), p.normal = -p.normal;
}

} // namespace oncollide
