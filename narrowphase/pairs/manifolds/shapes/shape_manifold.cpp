#include <oncollide/narrowphase/pairs/manifolds/shapes/shape_manifold.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <oncollide/narrowphase/pairs/manifolds/points/candidate.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/feature_bits.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/box_points.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/contact_points.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/shape_measures.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/shapes/box_axes.hpp>
#include <oncollide/narrowphase/shapes/least_translation.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

/// Share of the sizes. Points less apart are one.
constexpr double same_point_share = 0x1p-20;
/// Share of the sizes. The decision may leave a gap open that is smaller.
constexpr double unsure = 0x1p-32;

/// Stands for a half-space where cores are compared.
const Convex& point_of_plane()
{
    static const Convex point = convex_of(Shape(Sphere{0}));
    return point;
}

/// Makes the region of two shapes, in a's frame.
class ShapeRegion {
public:
    ShapeRegion(const PairTask& task, const ManifoldOptions& options)
        : task_(task), options_(options), placed_(task), plane_(task.a->kind() == Kind::half_space),
          b_(task.b->convex()), a_(plane_ ? point_of_plane() : task.a->convex()),
          cores_(a_, b_, placed_.b_to_a, placed_.slack),
          rounding_(cores_.rounding() + placed_.slack * (cores_.size() + cores_.radius() + apart())),
          boxes_(!plane_ && are_boxes(cores_))
    {
    }
    void find(PairWorker& worker, Manifold& manifold);

private:
    double apart() const { return placed_.b_to_a.translation.norm(); }
    double size() const { return (plane_ ? 0 : a_.extent) + b_.extent + cores_.radius(); }
    double smaller() const
    {
        const double of_b = b_.extent + b_.radius;
        return plane_ ? of_b : std::min(a_.extent + a_.radius, of_b);
    }
    LeastTranslation on_plane() const;
    bool set_kind(PairWorker& worker);
    void find_faces();
    void prefer_face(const ContactFace& face, double sign);
    void add_points();
    void find_points();
    bool meet_in_one_point() const;
    bool may_hold() const;
    bool reaches() const;
    bool faces_are_nearest();
    void add_deepest();
    ManifoldPoint point(const FewPoints::Candidate& c, const Vector3d& normal) const;

    const PairTask& task_;
    const ManifoldOptions& options_;
    const PlacedPair placed_;
    const bool plane_;
    const Convex& b_;
    const Convex& a_;
    const ConvexDifference cores_;
    const double rounding_;
    const bool boxes_;
    LeastTranslation found_{};
    RegionKind kind_{};
    bool meet_ = false; ///< certainly
    ContactFace face_a_, face_b_;
    ContactPoints points_;
};

/// The depth of a half-space: its plane is z = 0.
LeastTranslation ShapeRegion::on_plane() const
{
    LeastTranslation found{};
    const Vector3d down = -placed_.b_to_a.rotation.row(2).transpose();
    found.normal = Vector3d::UnitZ(), found.normal_error = 0x1p-48 + 8 * placed_.slack;
    found.on_b = placed_.b_to_a(b_.support(down)), found.has_points = true;
    found.on_a = {found.on_b.x(), found.on_b.y(), 0};
    const double depth = b_.radius - found.on_b.z();
    found.lower = depth - rounding_, found.upper = depth + rounding_;
    found.beyond = found.upper < -options_.margin - unsure * size();
    return found;
}

/// False: they have no region.
bool ShapeRegion::set_kind(PairWorker& worker)
{
    if (found_.lower > 0) {
        kind_ = RegionKind::crossing, meet_ = true;
        return true;
    }
    kind_ = RegionKind::near;
    const double gap = -found_.upper;                                   // a lower bound
    if (gap > 0 && gap <= options_.margin + 4 * rounding_) return true; // as near as decide() may see it
    if (gap > unsure * size()) return false;
    // Rounding hides it: the decision counts, whose own bounds may be wider.
    const Finding decided = tests_for(task_).decide(worker, task_, {}, nullptr);
    const bool separate = decided.verdict == Verdict::separate;
    meet_ = decided.verdict == Verdict::colliding;
    // If the decision is open and they may be apart by more than rounding, they are only near.
    if (gap <= 0 && (meet_ || (!separate && found_.lower >= -hidden_gap * rounding_))) kind_ = RegionKind::touching;
    return !separate || (gap <= 0 && options_.margin > 0 && decided.bound <= options_.margin);
}

void ShapeRegion::find_faces()
{
    const Vector3d& n = found_.normal;
    if (plane_)
        face_a_.count = 0, face_a_.off = 0, face_a_.face = face_feature(0), face_a_.normal = n;
    else
        find_face(*task_.a, n, face_a_);
    find_face(*task_.b, cores_.into_b(-n), face_b_);
    face_b_.place(placed_.b_to_a);
}

/// Takes a face's normal for the region's if it parts the shapes as well; it has less rounding than one from a
/// distance, and is the same for all shallow contacts of the face.
void ShapeRegion::prefer_face(const ContactFace& face, double sign)
{
    if (!face.flat()) return;
    const Vector3d n = sign * face.normal.normalized();
    const double cosine = n.dot(found_.normal);
    if (cosine < ContactPoints::facing || n == found_.normal) return;
    const double width = -n.dot(cores_.support(-n).w) + cores_.radius();
    const bool flat = cores_.flat_sided() && cores_.radius() == 0;
    const double more = flat ? face_preference(found_.upper, smaller()) : 0x1p-20 * std::abs(found_.upper);
    if (width > found_.upper + more + 16 * rounding_) return;
    // Overlapping polytopes have the face's normal; for others the true direction stays where it was.
    const double turned = angle_between(n, found_.normal) + found_.normal_error;
    found_.normal = n, found_.normal_error = flat && found_.lower > 0 ? 0x1p-48 + 8 * placed_.slack : turned;
    found_.upper = width + rounding_, found_.lower = std::min(found_.lower, found_.upper);
}

void ShapeRegion::add_deepest()
{
    if (boxes_) find_faces();
    if (!found_.has_points) { // a face's normal; the faces' common part does not reach the depth
        found_ = deepest_translation(cores_);
        points_.normal = found_.normal, points_.points.clear();
    }
    if (!plane_) improve_points(cores_, found_);
    const Vector3d& n = found_.normal;
    const Vector3d axis_b = placed_.b_to_a.rotation.col(2);
    const Vector3d on_b =
        surface_at(b_, axis_b, cores_.into_b(found_.on_b - placed_.b_to_a.translation).z(), found_.on_b, -n, rounding_);
    const Vector3d on_a =
        plane_ ? found_.on_a : surface_at(a_, Vector3d::UnitZ(), found_.on_a.z(), found_.on_a, n, rounding_);
    points_.add(on_a, on_b, found_.off, face_a_.face, face_b_.face);
}

void ShapeRegion::add_points()
{
    points_.normal = found_.normal;
    const double over_a = face_a_.flat() || plane_ ? face_a_.normal.dot(found_.normal) : 0,
                 over_b = face_b_.flat() ? -face_b_.normal.dot(found_.normal) : 0;
    if (std::max(over_a, over_b) >= ContactPoints::facing) {
        if (over_a + 0x1p-20 >= over_b)
            points_.add_over(face_a_, face_b_, b_, true, 4 * rounding_);
        else
            points_.add_over(face_b_, face_a_, a_, false, 4 * rounding_);
    } else if (face_a_.count == 2 && face_b_.count == 2) {
        points_.add_along(face_a_, a_, face_b_, b_);
    }
}

/// True if the points reach the depth that is certain.
bool ShapeRegion::reaches() const
{
    return !points_.points.empty() &&
           points_.points.deepest() >= found_.lower - face_preference(found_.lower, smaller()) - 16 * rounding_;
}

/// @param normal  of the region, in the world
ManifoldPoint ShapeRegion::point(const FewPoints::Candidate& c, const Vector3d& normal) const
{
    const Eigen::Isometry3d& pose = *task_.pose_a;
    return {pose * c.on_a, pose * c.on_b, c.depth, c.off + 8 * rounding_, c.of_a, c.of_b, normal};
}

/// True for spheres and capsules of which the nearest points are known and that do not lie along each other.
bool ShapeRegion::meet_in_one_point() const
{
    if (plane_ || !found_.has_points || !is_thin(a_) || !is_thin(b_)) return false;
    const double sine = placed_.b_to_a.rotation.col(2).head<2>().norm();
    return a_.low == a_.high || b_.low == b_.high || sine > ContactPoints::along_each_other;
}

/// Finds the points along the normal, or along a face's.
void ShapeRegion::find_points()
{
    points_.points.clear();
    if (meet_in_one_point()) {
        points_.normal = found_.normal, face_a_.face = face_b_.face = face_feature(0);
        return;
    }
    if (boxes_ && found_.of_axes) {
        points_.normal = found_.normal;
        find_box_points(a_, b_, placed_.b_to_a, found_.normal, ContactPoints::facing, 4 * rounding_, points_.points);
        return;
    }
    find_faces();
    const LeastTranslation found = found_;
    if (!plane_ && !found_.of_axes) prefer_face(face_a_, 1), prefer_face(face_b_, -1);
    add_points();
    const bool parts_better = found_.upper + 16 * rounding_ < found.upper;
    if (!reaches() && found.normal != found_.normal && !parts_better)
        found_ = found, points_.points.clear(), add_points();
}

/// True if a point proves that the gap of two boxes along the normal is their distance.
bool ShapeRegion::faces_are_nearest()
{
    if (points_.points.empty() || !(found_.upper < 0)) return false;
    const double deepest = points_.points.deepest() - 8 * rounding_;
    if (deepest < found_.upper - 64 * rounding_) return false;
    found_.lower = deepest, found_.normal_error = angle_to_shortest(-found_.upper, -found_.lower);
    return true;
}

/// False: neither is inside the other, which would have to move out by at least the width of a ball in it.
bool ShapeRegion::may_hold() const
{
    const double of_b = b_.inner + b_.radius, least = plane_ ? of_b : std::min(a_.inner + a_.radius, of_b);
    return kind_ == RegionKind::crossing && found_.upper >= 2 * least;
}

void ShapeRegion::find(PairWorker& worker, Manifold& manifold)
{
    if (!plane_ && cores_.least() - cores_.radius() > options_.margin + unsure * size()) return;
    found_ = plane_ ? on_plane() : least_translation(cores_, options_.margin + unsure * size(), false);
    if (found_.beyond || !set_kind(worker)) return;
    find_points();
    if (found_.lower == -unbounded && !faces_are_nearest()) {
        found_ = least_translation(cores_, options_.margin + unsure * size());
        if (found_.beyond || !set_kind(worker)) return;
        find_points();
    }
    if (!reaches()) add_deepest();
    points_.points.drop_shallow(-options_.margin - 8 * rounding_);
    ManifoldRegion region{};
    region.kind = may_hold() && holds_other(task_, placed_.b_to_a) ? RegionKind::enclosed : kind_;
    if (options_.measures) measure_region(task_, placed_.b_to_a, points_.points.chosen(), found_.normal, region);
    region.found = points_.points.count();
    // Far from the origin, points of a small face may have the same coordinates.
    const double same_point = same_point_share * size() + 0x1p-49 * task_.pose_a->translation().norm();
    points_.points.choose(found_.normal, same_point, std::min(options_.points_per_region, options_.points_per_pair));
    region.normal = (task_.pose_a->linear() * found_.normal).normalized(), region.normal_error = found_.normal_error;
    region.depth_lower = meet_ ? std::max(found_.lower, 0.0) : found_.lower;
    region.depth_upper = std::max(found_.upper, region.depth_lower);
    region.first = static_cast<std::uint32_t>(manifold.points.size()), region.count = points_.points.count();
    for (const FewPoints::Candidate& c : points_.points.chosen()) {
        const ManifoldPoint p = point(c, region.normal);
        region.depth_upper = std::max(region.depth_upper, p.depth - p.depth_error);
        manifold.points.push_back(p);
    }
    if (options_.measures)
        region.lost = lost_of_shapes(task_, placed_.b_to_a, std::span(manifold.points).subspan(region.first));
    manifold.regions.push_back(region);
}

} // namespace

bool are_shapes(const PairTask& task)
{
    return task.b->is_bounded_shape() && (task.a->is_bounded_shape() || task.a->kind() == Kind::half_space);
}

void manifold_of_shapes(PairWorker& worker, const PairTask& task, const ManifoldOptions& options, Manifold& manifold)
{
    ShapeRegion(task, options).find(worker, manifold);
}

} // namespace oncollide
