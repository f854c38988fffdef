#include <oncollide/narrowphase/pairs/manifolds/convex_on_surface.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/candidate.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/feature_bits.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/placed_convex.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/walks/box_walk_all.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

/// Cosine of a milliradian. Directions that differ by less are one.
constexpr double one_direction = 1 - 5e-7;
/// Share of the shape's size: a decision may see a gap that is smaller as closed.
constexpr double doubt = 0x1p-40;
/// Share of the shape's size. Points less apart are one: neighbouring triangles have the same point.
constexpr double one_point_share = 0x1p-12;
/// Share of the size: points that may be farther from the surfaces count only without others.
constexpr double loose_share = 0x1p-20;
/// Share of a triangle's size: points nearer to an edge lie on it.
constexpr double on_edge = 0x1p-20;
/// Cosine. A direction that is less against a face's normal counts as along the face.
constexpr double against = -0x1p-10;
/// Triangles. A box or a hull that reaches more has regions of joined areas.
constexpr std::size_t most_reached = 64;
/// Points of a region; with more, the outermost are kept.
constexpr std::uint32_t many_points = 64, kept_points = 16;

} // namespace

/// The pair; the triangles are taken as body A of each small problem, so that its normal points to the shape.
struct ConvexOnSurface::Setup {
    PairWorker& worker;
    const PairTask& task;
    const ManifoldJob& job;
    const bool of_a; ///< the shape is the job's a
    const PlacedSurface& surface;
    const Model& model;
    const PlacedConvex shape;
    const bool round;
    const double size, margin, error; ///< error: of the surface's coordinates
    bool meets = false;               ///< a triangle may meet the shape
    bool hidden = false;              ///< they meet, and rounding hides in which triangle
    std::optional<bool> inside;       ///< the shape's middle is inside the surface; found when needed

    Setup(PairWorker& w, const PairTask& t, const ManifoldJob& j, const RelativePose& b_to_a)
        : worker(w), task(t), job(j), of_a(t.a->is_bounded_shape()), surface(of_a ? j.b : j.a),
          model(of_a ? *t.a : *t.b),
          shape(model, of_a ? RelativePose(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()) : b_to_a,
                slack_of(t)),
          round(model.kind() == Kind::round), size(shape.size()), margin(j.options.margin), error(surface.error())
    {
    }
    /// True if the shape, which meets no triangle, is inside the surface.
    bool is_inside()
    {
        if (!inside) inside = !meets && surface.holds(shape.middle, worker.locator).value_or(false);
        return *inside;
    }
};

bool ConvexOnSurface::takes(const PairTask& task)
{
    const auto shape = [](const Model& m) {
        return m.kind() == Kind::round ||
               (m.kind() == Kind::polytope && m.convex().inner > 0 && m.convex().count <= operand::most_points);
    };
    const auto ground = [](const Model& m) {
        return m.kind() == Kind::mesh || m.kind() == Kind::terrain || m.kind() == Kind::map;
    };
    return (shape(*task.a) && ground(*task.b)) || (ground(*task.a) && shape(*task.b));
}

/// False: a box or a hull reaches too many triangles, or holds all triangles in reach.
bool ConvexOnSurface::find_reached(const Setup& s)
{
    triangles_.clear(), reached_.clear();
    const double more = s.margin + s.error + doubt * s.size + 64 * s.job.rounding;
    const Eigen::Isometry3d &of_shape = s.of_a ? *s.task.pose_a : *s.task.pose_b,
                            &of_other = s.of_a ? *s.task.pose_b : *s.task.pose_a;
    const RelativePose other_to_shape(of_shape, of_other);
    const ShapeTree& tree = s.model.shape_tree();
    s.surface.with_tree([&](auto& other) {
        s.worker.walk(tree, other).all_near(tree, other, other_to_shape, more, [&](const auto& pair) {
            triangles_.push_back(pair.b);
        });
    });
    std::ranges::sort(triangles_);
    bool within = true;
    for (const std::uint32_t t : triangles_) {
        const TrianglePoints corners = s.surface.points(t);
        if (s.shape.box_is_apart(corners, more)) continue;
        Reached r{t, {}, corners, Vector3d::Zero(), {}};
        r.face = unit_normal(r.corners[0], r.corners[1], r.corners[2]);
        // Behind an open surface is no inside: the shape is on the side of its middle.
        if (!s.surface.solid() && r.face.dot(s.shape.middle - r.corners[0]) < 0) r.face = -r.face;
        r.least = s.shape.part(r.corners, r.face, more, r.face_depth);
        if (r.least.beyond) continue;
        r.numbers = s.surface.corners(t);
        r.least.lower -= s.error, r.least.upper += s.error;
        r.apart = r.least.upper < 0;
        within = within && std::ranges::all_of(r.corners, [&](const Vector3d& p) { return s.shape.holds(p); });
        reached_.push_back(r);
        if (!s.round && reached_.size() > most_reached) return false;
    }
    return s.round || !within || reached_.empty();
}

/// The triangle around the edge or the corner of the direction that rises along it; none: the direction leads out.
std::uint32_t ConvexOnSurface::risen_triangle(const Setup& s, const Reached& r, const Vector3d& n) const
{
    constexpr std::uint32_t none = PlacedSurface::none;
    const Vector3d& p = r.least.on_a;
    const auto& c = r.corners;
    const double size = std::max({(c[1] - c[0]).norm(), (c[2] - c[1]).norm(), (c[0] - c[2]).norm()});
    const double near = on_edge * size + 4 * s.job.rounding;
    const auto below = [&](std::uint32_t vertex) { // seen from p along n
        const Vector3d way = s.surface.point(vertex) - p;
        return n.dot(way) <= 0x1p-16 * way.norm() + 2 * near;
    };
    for (int k = 0; k < 3; ++k)
        if ((c[k] - p).norm() <= near) { // all triangles around the corner
            std::uint32_t t = r.triangle;
            for (int turns = 0; turns < 64; ++turns) {
                const auto around = s.surface.corners(t);
                const int at = int(std::ranges::find(around, r.numbers[k]) - around.begin());
                if (at == 3) break;
                if (!below(around[(at + 1) % 3]) || !below(around[(at + 2) % 3])) return t;
                t = s.surface.across(t, at);
                if (t == none || t == r.triangle) break;
            }
            return none;
        }
    for (int k = 0; k < 3; ++k) {
        const Vector3d edge = c[(k + 1) % 3] - c[k];
        if ((p - c[k]).cross(edge).norm() > near * edge.norm()) continue;
        const std::uint32_t t = s.surface.across(r.triangle, k);
        if (t == none) return none;
        for (const std::uint32_t v : s.surface.corners(t))
            if (v != r.numbers[k] && v != r.numbers[(k + 1) % 3]) return below(v) ? none : t;
        return none;
    }
    return none; // inside of the triangle
}

/// Makes the face's normal the direction.
void ConvexOnSurface::take_face(const Setup& s, Reached& r) const
{
    LeastTranslation& least = r.least;
    least.normal = r.face, least.upper = r.face_depth + 16 * s.job.rounding + s.error;
    least.lower = std::min(least.lower, least.upper);
    least.normal_error = 0x1p-46 + 8 * s.shape.slack;
    r.way = Way::out;
}

/// Chooses the direction of a triangle.
ConvexOnSurface::Way ConvexOnSurface::set_way(Setup& s, Reached& r) const
{
    LeastTranslation& least = r.least;
    const bool flat = !r.face.isZero(0);
    if (flat && r.face_depth <= least.upper + face_preference(least.upper, s.size)) {
        take_face(s, r);
    } else if (flat && least.normal.dot(r.face) < against) { // the shape's middle is behind the surface
        if (r.apart && !s.is_inside()) return Way::none;
        if (!s.round) return Way::deep;
        const Vector3d p = s.shape.lowest(r.face) + r.face_depth * r.face;
        for (int k = 0; k < 3 && s.surface.solid(); ++k)
            if ((r.corners[(k + 1) % 3] - r.corners[k]).cross(p - r.corners[k]).dot(r.face) < 0) return Way::none;
        const double gap = -least.upper;
        take_face(s, r), r.inside = r.apart;
        if (r.inside) least.lower = std::min(gap, least.upper);
        return Way::out;
    } else {
        r.risen = risen_triangle(s, r, least.normal);
        if (r.risen != PlacedSurface::none) return Way::blocked;
    }
    if (s.round) return Way::out;
    const double top = least.normal.dot(least.has_points ? least.on_a : r.corners[0]);
    return least.normal.dot(s.shape.middle) > top ? Way::out : Way::deep;
}

/// True if a blocked triangle gives a direction although another one rises there: that one is not in reach, or is
/// blocked, too, and farther above the shape's lowest point.
bool ConvexOnSurface::gives_direction(const Reached& r) const
{
    const auto risen = std::ranges::lower_bound(reached_, r.risen, {}, &Reached::triangle);
    return risen == reached_.end() || risen->triangle != r.risen ||
           (risen->way == Way::blocked && r.face_depth <= risen->face_depth);
}

/// The group of a direction and a height, or the number of groups.
std::size_t ConvexOnSurface::group_of(const Setup& s, const Vector3d& n, double height) const
{
    const double apart = 1e-3 * s.size + 16 * s.job.rounding;
    std::size_t g = 0;
    while (g < group_count_ &&
           !(groups_[g].points.normal.dot(n) > one_direction && std::abs(groups_[g].height - height) <= apart))
        ++g;
    return g;
}

/// Adds the triangle's points to the group of its direction and height.
void ConvexOnSurface::add_to_group(const Setup& s, const Reached& r)
{
    const Vector3d& n = r.least.normal;
    const double height = n.dot(r.least.has_points ? r.least.on_a : r.corners[0]);
    const std::size_t g = group_of(s, n, height);
    if (g == group_count_) {
        if (++group_count_ > groups_.size()) groups_.resize(group_count_), face_of_ = nullptr;
        Group& made = groups_[g];
        made.points.normal = n, made.points.points.clear(), made.height = height;
        made.lower = -unbounded, made.upper = -unbounded, made.normal_error = 0, made.apart = made.inside = true,
        made.left_out = 0;
    }
    Group& group = groups_[g];
    const Vector3d& m = group.points.normal;
    double top = -unbounded;
    for (const Vector3d& p : r.corners) top = std::max(top, m.dot(p));
    group.lower = std::max(group.lower, r.least.lower), group.apart &= r.apart, group.inside &= r.inside;
    group.upper = std::max(group.upper, top - m.dot(s.shape.lowest(m)) + s.error + 16 * s.job.rounding);
    group.normal_error = std::max(group.normal_error, std::max(r.least.normal_error, angle_between(n, m)));
    add_points(s, r, group);
    FewPoints& points = group.points.points;
    if (points.count() <= many_points) return;
    const std::uint32_t before = points.count();
    points.choose(m, one_point_share * s.size, kept_points);
    group.left_out += before - points.count();
}

void ConvexOnSurface::add_points(const Setup& s, const Reached& r, Group& group)
{
    const Vector3d& m = group.points.normal;
    if (face_of_ != &group) {
        find_face(s.model, s.shape.into_shape(-m), face_);
        face_.place(s.shape.into), face_of_ = &group;
    }
    ContactFace flat;
    flat.count = 3, flat.off = s.error, flat.rounded = false, flat.face = s.surface.face(r.triangle);
    flat.normal = r.face;
    for (unsigned k = 0; k < 3; ++k) flat.corner[k] = r.corners[k], flat.number[k] = k;
    FewPoints& points = group.points.points;
    const std::uint32_t before = points.count();
    if (r.face.dot(m) >= ContactPoints::facing)
        group.points.add_over(flat, face_, s.shape.solid, true, 4 * s.job.rounding);
    else if (face_.flat() && -face_.normal.dot(m) >= ContactPoints::facing)
        group.points.add_over(face_, flat, s.shape.solid, false, 4 * s.job.rounding);
    if (points.count() == before && r.least.has_points) {
        const Vector3d axis = s.shape.into.rotation.col(2);
        const Vector3d on_b = surface_at(s.shape.solid, axis, axis.dot(r.least.on_b - s.shape.into.translation),
                                         r.least.on_b, -m, s.job.rounding);
        if (const double depth = m.dot(r.least.on_a - on_b); depth >= r.least.lower - s.error - 1e-3 * s.size)
            group.points.add(r.least.on_a, on_b, s.error + r.least.off, flat.face, face_.face);
        return;
    }
    const auto of_surface = [&](FeatureBits bits) {
        for (unsigned k = 0; k < 3; ++k) {
            const unsigned next = (k + 1) % 3;
            if (bits == flat.vertex(k)) return s.surface.vertex(r.numbers[k]);
            if (bits == flat.edge(k, next)) return s.surface.edge(r.numbers[k], r.numbers[next]);
        }
        return flat.face;
    };
    for (FewPoints::Candidate& c : points.from(before))
        if (c.of_a != flat.face) c.of_a = of_surface(c.of_a);
}

/// Adds triangles whose direction leads to a risen one: with the face's normal, if no other triangle gives the
/// surface's direction there, or if the face's plane has a group.
void ConvexOnSurface::add_blocked(const Setup& s)
{
    const auto in_front = [&](const Reached& r) {
        return !r.face.isZero(0) && r.face.dot(s.shape.middle - r.corners[0]) > 0 && r.face_depth >= -s.margin &&
               (!r.apart || r.face_depth <= 0);
    };
    for (const bool joins : {false, true})
        for (Reached& r : reached_) {
            if (r.way != Way::blocked || !in_front(r)) continue;
            const bool joined = group_of(s, r.face, r.face.dot(r.corners[0])) < group_count_;
            if (joined != joins || !(joins || gives_direction(r))) continue;
            Reached by_face = r; // it adds points of the plane alone
            take_face(s, by_face), by_face.least.has_points = false;
            add_to_group(s, by_face);
            const FewPoints& points = groups_[group_count_ - 1].points.points;
            if (points.empty() || points.deepest() < -s.margin - 8 * s.job.rounding) --group_count_, face_of_ = nullptr;
        }
}

void ConvexOnSurface::add_region(const Setup& s, Group& group) const
{
    FewPoints& points = group.points.points;
    const ManifoldJob& job = s.job;
    if (points.empty()) {
        const Vector3d& n = group.points.normal;
        const Vector3d q = s.shape.lowest(n);
        group.points.add(q + (group.height - n.dot(q)) * n, q, s.size, face_feature(0), face_feature(0));
    }
    points.drop_loose(s.error + loose_share * s.size + 16 * job.rounding);
    points.drop_shallow(-s.margin - 8 * job.rounding);
    ManifoldRegion region{};
    region.kind = group.inside               ? RegionKind::enclosed
                  : group.apart && !s.hidden ? RegionKind::near
                  : group.lower > 0          ? RegionKind::crossing
                                             : RegionKind::touching;
    region.open = !s.surface.solid();
    region.found = points.count() + group.left_out;
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

bool ConvexOnSurface::add(PairWorker& worker, const PairTask& task, const ManifoldJob& job, const RelativePose& b_to_a)
{
    Setup s(worker, task, job, b_to_a);
    if (!find_reached(s)) return false;
    if (reached_.empty()) return true;
    const bool certain = std::ranges::any_of(reached_, [](const Reached& r) { return r.least.lower > 0; });
    // Where rounding hides all contacts, the decision counts.
    const bool apart = !certain && decide_both_orders(worker, task).verdict == Verdict::separate;
    if (apart && s.margin == 0) return true;
    double nearest = -unbounded;
    for (const Reached& r : reached_) nearest = std::max(nearest, r.least.upper), s.meets |= !r.apart;
    s.hidden = !apart && !s.meets;
    if (apart)
        for (Reached& r : reached_) r.apart = true; // the decision sees a gap that rounding hides
    // If they are not apart, the nearest triangle has a region, even if all are apart by a rounding.
    const double most = s.margin + 4 * s.job.rounding, least = apart ? -most : std::min(-most, nearest);
    std::erase_if(reached_, [&](const Reached& r) { return r.least.upper < least; });
    for (Reached& r : reached_)
        if ((r.way = set_way(s, r)) == Way::deep) return false;
    group_count_ = 0, face_of_ = nullptr;
    for (const bool by_face : {true, false}) // the normals of faces have less rounding in them
        for (const Reached& r : reached_)
            if (r.way == Way::out && (r.least.normal == r.face) == by_face) add_to_group(s, r);
    add_blocked(s);
    if (group_count_ == 0 && !s.round) return reached_.empty();
    if (group_count_ == 0 && !reached_.empty()) { // no direction leads out: one triangle stands for all
        Reached one = *std::ranges::max_element(reached_, {}, [](const Reached& r) { return r.least.upper; });
        // A way through to the other side of the surface is no way out.
        if (s.surface.solid() && !one.face.isZero(0) && one.least.normal.dot(one.face) < against) take_face(s, one);
        add_to_group(s, one);
    }
    for (std::size_t g = 0; g < group_count_; ++g) add_region(s, groups_[g]);
    return true;
}

} // namespace oncollide
