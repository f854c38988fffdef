#include <oncollide/narrowphase/pairs/manifolds/round_on_surface.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/candidate.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/feature_bits.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/walks/box_walk_queries.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

/// Shares of the depth and of the size. A face's direction is taken if it is worse than the least by less.
constexpr double nearly_least = 1.0 / 128, close_to_least = 0x1p-26;
/// Cosine of a milliradian. Directions that differ by less are one.
constexpr double one_direction = 1 - 5e-7;
/// Share of the shape's size: a decision may see a gap that is smaller as closed.
constexpr double doubt = 0x1p-40;
/// Share of the shape's size. Points less apart are one: neighbouring triangles have the same point.
constexpr double one_point_share = 0x1p-12;
/// Share of a triangle's size: points nearer to an edge lie on it.
constexpr double on_edge = 0x1p-20;

} // namespace

/// The pair; the triangles are taken as body A of each small problem, so that its normal points to the shape.
struct RoundOnSurface::Setup {
    PairWorker& worker;
    const PairTask& task;
    const ManifoldJob& job;
    const bool of_a; ///< the shape is the job's a
    const PlacedSurface& surface;
    Model& shape;
    const RelativePose into;                 ///< moves the shape into the frame of the pair
    const double slack, size, margin, error; ///< error: of the surface's coordinates

    Setup(PairWorker& w, const PairTask& t, const ManifoldJob& j, const RelativePose& b_to_a)
        : worker(w), task(t), job(j), of_a(j.a.round()), surface(of_a ? j.b : j.a), shape(of_a ? *t.a : *t.b),
          into(of_a ? RelativePose(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()) : b_to_a),
          slack(PlacedPair(*t.pose_a, *t.pose_b).slack), size(shape.convex().extent + shape.convex().radius),
          margin(j.options.margin), error(surface.error())
    {
    }
    Vector3d into_shape(const Vector3d& d) const { return into.rotation.transpose() * d; }
    /// The shape's lowest point along a direction, in the frame of the pair.
    Vector3d lowest(const Vector3d& up) const
    {
        return into(shape.convex().support(into_shape(-up))) - shape.convex().radius * up;
    }
};

void RoundOnSurface::find_reached(const Setup& s)
{
    triangles_.clear();
    const double more = s.margin + s.error + doubt * s.size + 64 * s.job.rounding;
    Convex grown = s.shape.convex();
    grown.radius += more;
    Aabb box = bounds_of(*s.shape.shape());
    box.min.array() -= more, box.max.array() += more;
    const ShapeTree tree(grown, box);
    const Eigen::Isometry3d &of_shape = s.of_a ? *s.task.pose_a : *s.task.pose_b,
                            &of_other = s.of_a ? *s.task.pose_b : *s.task.pose_a;
    const RelativePose other_to_shape(of_shape, of_other);
    s.surface.with_tree([&](auto& other) {
        auto& walk = s.worker.walk(tree, other);
        walk.leaves().prepare(s.slack, true);
        walk.meetings(
            tree, other, other_to_shape, {}, [&](const auto& pair) { return triangles_.push_back(pair.b), true; },
            [](const auto&) { return false; });
    });
    std::ranges::sort(triangles_);
    triangles_.erase(std::unique(triangles_.begin(), triangles_.end()), triangles_.end());
    reached_.clear();
    for (const std::uint32_t t : triangles_) {
        Reached r{t, s.surface.points(t), Vector3d::Zero(), {}};
        r.face = unit_normal(r.corners[0], r.corners[1], r.corners[2]);
        const Convex flat = convex_of(r.corners);
        r.least = least_translation(ConvexDifference(flat, s.shape.convex(), s.into, s.slack), more);
        r.least.lower -= s.error, r.least.upper += s.error;
        if (!r.least.beyond) reached_.push_back(r);
    }
}

/// True if a direction from a triangle's edge or corner to the shape leads away from all triangles around it.
bool RoundOnSurface::leads_out(const Setup& s, const Reached& r, const Vector3d& n) const
{
    const Vector3d& p = r.least.on_a;
    const auto& c = r.corners;
    const double size = std::max({(c[1] - c[0]).norm(), (c[2] - c[1]).norm(), (c[0] - c[2]).norm()});
    const double near = on_edge * size + 4 * s.job.rounding;
    const auto numbers = s.surface.corners(r.triangle);
    const auto below = [&](std::uint32_t vertex) { // seen from p along n
        const Vector3d way = s.surface.point(vertex) - p;
        return n.dot(way) <= 0x1p-16 * way.norm() + 2 * near;
    };
    for (int k = 0; k < 3; ++k)
        if ((c[k] - p).norm() <= near) { // all triangles around the corner
            std::uint32_t t = r.triangle;
            for (int turns = 0; turns < 64; ++turns) {
                const auto around = s.surface.corners(t);
                const int at = int(std::ranges::find(around, numbers[k]) - around.begin());
                if (at == 3) break;
                if (!below(around[(at + 1) % 3]) || !below(around[(at + 2) % 3])) return false;
                t = s.surface.across(t, at);
                if (t == PlacedSurface::none || t == r.triangle) break;
            }
            return true;
        }
    for (int k = 0; k < 3; ++k) {
        const Vector3d edge = c[(k + 1) % 3] - c[k];
        if ((p - c[k]).cross(edge).norm() > near * edge.norm()) continue;
        const std::uint32_t t = s.surface.across(r.triangle, k);
        if (t == PlacedSurface::none) return true;
        for (const std::uint32_t v : s.surface.corners(t))
            if (v != numbers[k] && v != numbers[(k + 1) % 3]) return below(v);
        return true;
    }
    return true; // inside of the triangle
}

/// Chooses the direction of a triangle; false: a neighbour gives it.
bool RoundOnSurface::set_direction(const Setup& s, Reached& r) const
{
    LeastTranslation& least = r.least;
    if (r.face.isZero(0)) return leads_out(s, r, least.normal);
    // Behind an open surface is no inside: the shape is on the side of its middle.
    if (!s.surface.solid() && r.face.dot(s.into(s.shape.convex().centre) - r.corners[0]) < 0) r.face = -r.face;
    const double depth = r.face.dot(r.corners[0] - s.lowest(r.face));
    const double rounding = 16 * s.job.rounding + s.error;
    const bool as_good = depth <= least.upper + nearly_least * std::abs(least.upper) + close_to_least * s.size;
    if (as_good || least.normal.dot(r.face) < -0x1p-10) {
        if (!as_good && s.surface.solid()) { // the shape's middle is behind the surface
            const Vector3d p = s.lowest(r.face) + depth * r.face;
            for (int k = 0; k < 3; ++k)
                if ((r.corners[(k + 1) % 3] - r.corners[k]).cross(p - r.corners[k]).dot(r.face) < 0) return false;
        }
        least.normal = r.face, least.upper = depth + rounding, least.lower = std::min(least.lower, least.upper);
        least.normal_error = 0x1p-46 + 8 * s.slack;
        return true;
    }
    return leads_out(s, r, least.normal);
}

/// Adds the triangle's points to the group of its direction and height.
void RoundOnSurface::add_to_group(const Setup& s, const Reached& r)
{
    const Vector3d& n = r.least.normal;
    const double height = n.dot(r.least.has_points ? r.least.on_a : r.corners[0]);
    const double apart = 1e-3 * s.size + 16 * s.job.rounding;
    std::size_t g = 0;
    while (g < group_count_ &&
           !(groups_[g].points.normal.dot(n) > one_direction && std::abs(groups_[g].height - height) <= apart))
        ++g;
    if (g == group_count_) {
        if (++group_count_ > groups_.size()) groups_.resize(group_count_);
        Group& made = groups_[g];
        made.points.normal = n, made.points.points.clear(), made.height = height;
        made.lower = -unbounded, made.upper = -unbounded, made.normal_error = 0;
    }
    Group& group = groups_[g];
    const Vector3d& m = group.points.normal;
    double top = -unbounded;
    for (const Vector3d& p : r.corners) top = std::max(top, m.dot(p));
    group.lower = std::max(group.lower, r.least.lower);
    group.upper = std::max(group.upper, top - m.dot(s.lowest(m)) + s.error + 16 * s.job.rounding);
    group.normal_error = std::max(group.normal_error, std::max(r.least.normal_error, angle_between(n, m)));
    ContactFace flat, face;
    flat.count = 3, flat.off = s.error, flat.rounded = false, flat.face = s.surface.face(r.triangle);
    flat.normal = r.face;
    for (unsigned k = 0; k < 3; ++k) flat.corner[k] = r.corners[k], flat.number[k] = s.surface.corners(r.triangle)[k];
    find_face(s.shape, s.into_shape(-m), face);
    face.place(s.into);
    const Convex& solid = s.shape.convex();
    const std::uint32_t before = group.points.points.count();
    if (r.face.dot(m) >= ContactPoints::facing)
        group.points.add_over(flat, face, solid, true, 4 * s.job.rounding);
    else if (face.flat() && -face.normal.dot(m) >= ContactPoints::facing)
        group.points.add_over(face, flat, solid, false, 4 * s.job.rounding);
    if (group.points.points.count() == before && r.least.has_points) {
        const Vector3d axis = s.into.rotation.col(2);
        const Vector3d on_b =
            surface_at(solid, axis, axis.dot(r.least.on_b - s.into.translation), r.least.on_b, -m, s.job.rounding);
        if (const double depth = m.dot(r.least.on_a - on_b); depth >= r.least.lower - s.error - 1e-3 * s.size)
            group.points.add(r.least.on_a, on_b, s.error + r.least.off, flat.face, face.face);
    }
}

void RoundOnSurface::add_region(const Setup& s, Group& group) const
{
    FewPoints& points = group.points.points;
    const ManifoldJob& job = s.job;
    if (points.empty()) {
        const Vector3d& n = group.points.normal;
        const Vector3d q = s.lowest(n);
        group.points.add(q + (group.height - n.dot(q)) * n, q, s.size, face_feature(0), face_feature(0));
    }
    points.drop_shallow(-s.margin - 8 * job.rounding);
    ManifoldRegion region{};
    region.kind = group.lower > 0 ? RegionKind::crossing : group.upper < 0 ? RegionKind::near : RegionKind::touching;
    region.open = !s.surface.solid();
    region.found = points.count();
    points.choose(group.points.normal, one_point_share * s.size,
                  std::min(job.options.points_per_region, job.options.points_per_pair));
    region.normal = s.of_a ? Vector3d(-group.points.normal) : group.points.normal;
    region.normal_error = group.normal_error;
    region.depth_lower = region.kind == RegionKind::near ? group.lower : std::max(group.lower, 0.0);
    region.depth_upper = std::max(group.upper, region.depth_lower);
    region.first = static_cast<std::uint32_t>(job.manifold.points.size()), region.count = points.count();
    region.centre.setZero();
    for (const FewPoints::Candidate& c : points.chosen()) {
        ManifoldPoint p{c.on_a, c.on_b, c.depth, c.off + 8 * job.rounding, c.of_a, c.of_b, group.points.normal};
        if (s.of_a) std::swap(p.point_a, p.point_b), std::swap(p.feature_a, p.feature_b), p.normal = -p.normal;
        region.depth_upper = std::max(region.depth_upper, p.depth - p.depth_error);
        region.centre += 0.5 / double(region.count) * (p.point_a + p.point_b);
        job.manifold.points.push_back(p);
    }
    region.lost = 2 * s.size + std::abs(region.depth_upper); // all contacts lie in the shape
    job.manifold.regions.push_back(region);
}

void RoundOnSurface::add(PairWorker& worker, const PairTask& task, const ManifoldJob& job, const RelativePose& b_to_a)
{
    const Setup s(worker, task, job, b_to_a);
    find_reached(s);
    if (reached_.empty()) return;
    const bool certain = std::ranges::any_of(reached_, [](const Reached& r) { return r.least.lower > 0; });
    // Where rounding hides all contacts, the decision counts.
    const bool apart = !certain && tests_for(task).decide(worker, task, {}, nullptr).verdict == Verdict::separate;
    if (apart && s.margin == 0) return;
    double nearest = -unbounded;
    for (const Reached& r : reached_) nearest = std::max(nearest, r.least.upper);
    // If they are not apart, the nearest triangle has a region, even if all are apart by a rounding.
    const double least = apart ? -s.margin : std::min(-s.margin, nearest);
    std::erase_if(reached_, [&](const Reached& r) { return r.least.upper < least; });
    group_count_ = 0;
    std::size_t best = 0; // the triangle that stands for all if no direction leads out
    for (std::size_t i = 0; i < reached_.size(); ++i) {
        if (reached_[i].least.upper > reached_[best].least.upper) best = i;
        Reached r = reached_[i];
        if (set_direction(s, r)) add_to_group(s, r);
    }
    if (group_count_ == 0 && !reached_.empty()) add_to_group(s, reached_[best]);
    for (std::size_t g = 0; g < group_count_; ++g) add_region(s, groups_[g]);
}

} // namespace oncollide
