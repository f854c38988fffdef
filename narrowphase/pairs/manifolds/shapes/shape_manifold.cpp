#include <oncollide/narrowphase/pairs/manifolds/shapes/shape_manifold.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <oncollide/narrowphase/pairs/manifolds/shapes/clipped_face.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/few_points.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/shape_measures.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/shapes/least_translation.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

/// Cosine of 10 degrees. A face that is more oblique to the normal has no points but the deepest.
constexpr double facing = 0.985;
/// Sine. Segments that differ by more have one point.
constexpr double along_each_other = 0.05;
/// Shares of the depth and of the sizes by which a face's normal may be worse than an edge's, and is taken all the
/// same.
constexpr double nearly = 1.0 / 128, close = 0x1p-24;

/// Makes the region of two shapes, in a's frame.
class ShapeRegion {
public:
    ShapeRegion(const PairTask& task, const ManifoldOptions& options)
        : task_(task), options_(options), placed_(*task.pose_a, *task.pose_b),
          plane_(task.a->kind() == Kind::half_space), b_(task.b->convex()),
          a_(plane_ ? point_of_plane : task.a->convex()), cores_(a_, b_, placed_.b_to_a, placed_.slack),
          rounding_(cores_.rounding() + placed_.slack * (cores_.size() + cores_.radius() + apart()))
    {
    }
    void find(PairWorker& worker, Manifold& manifold);

private:
    static const Convex point_of_plane;

    double apart() const { return placed_.b_to_a.translation.norm(); }
    double size() const { return (plane_ ? 0 : a_.extent) + b_.extent + cores_.radius(); }
    LeastTranslation on_plane() const;
    bool set_kind(PairWorker& worker);
    void find_faces();
    void prefer_face(const ContactFace& face, double sign);
    void add_points();
    bool reaches() const;
    void add_over(const ContactFace& flat, const ContactFace& face, bool flat_is_a);
    void add_along();
    void add_deepest();
    void add(Vector3d on_a, Vector3d on_b, double off, FeatureBits of_a, FeatureBits of_b);
    Vector3d surface(const Convex& c, const Vector3d& axis, const Vector3d& at, const Vector3d& out, int end) const;
    ManifoldPoint point(const FewPoints::Candidate& c) const;

    const PairTask& task_;
    const ManifoldOptions& options_;
    const PlacedPair placed_;
    const bool plane_;
    const Convex& b_;
    const Convex& a_;
    const ConvexDifference cores_;
    const double rounding_;
    LeastTranslation found_{};
    RegionKind kind_{};
    ContactFace face_a_, face_b_;
    ClippedFace clipped_;
    FewPoints points_;
};

const Convex ShapeRegion::point_of_plane = convex_of(Shape(Sphere{0}));

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
    found.beyond = found.upper < -options_.margin;
    return found;
}

/// False: they have no region.
bool ShapeRegion::set_kind(PairWorker& worker)
{
    if (found_.lower > 0) {
        kind_ = RegionKind::crossing;
    } else if (found_.upper < 0) {
        kind_ = RegionKind::near;
        return -found_.upper <= options_.margin && options_.margin > 0;
    } else { // rounding hides it
        const bool apart = tests_for(task_).decide(worker, task_, {}, nullptr).verdict == Verdict::separate;
        kind_ = apart ? RegionKind::near : RegionKind::touching;
        return !apart || options_.margin > 0;
    }
    return true;
}

void ShapeRegion::find_faces()
{
    const Vector3d& n = found_.normal;
    if (plane_)
        face_a_.count = 0, face_a_.off = 0, face_a_.face = FeatureBits{3} << 62, face_a_.normal = n;
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
    if (cosine < facing || n == found_.normal) return;
    const double width = -n.dot(cores_.support(-n).w) + cores_.radius();
    const bool flat = cores_.flat_sided() && cores_.radius() == 0;
    const double more = flat ? nearly * std::abs(found_.upper) + close * size() : 0x1p-20 * std::abs(found_.upper);
    if (width > found_.upper + more + 16 * rounding_) return;
    found_.normal = n, found_.normal_error = 0x1p-48 + 8 * placed_.slack;
    found_.upper = width + rounding_, found_.lower = std::min(found_.lower, found_.upper);
}

/// @param on_a, on_b  points of the surfaces; the second is moved onto the line along the normal through the first
/// @param off  metres: how far both may be from the surfaces
void ShapeRegion::add(Vector3d on_a, Vector3d on_b, double off, FeatureBits of_a, FeatureBits of_b)
{
    const double depth = found_.normal.dot(on_a - on_b);
    const Vector3d there = on_a - depth * found_.normal;
    points_.add({on_a, there, depth, off + (there - on_b).norm(), of_a, of_b});
}

/// A point of the surface at a point of the core. A segment's surface is a cylinder around it, and a ball at its ends.
/// @param end  1 or -1: `at` is the end of a segment along its axis, or against it
Vector3d ShapeRegion::surface(const Convex& c, const Vector3d& axis, const Vector3d& at, const Vector3d& out,
                              int end) const
{
    if (c.radius == 0) return at;
    const double along = axis.dot(out);
    if (axis.isZero(0) || end * along >= 0) return at + c.radius * out;
    return at + c.radius * (out - along * axis).normalized();
}

/// Of a segment, unit; 0 for other faces.
Vector3d axis_of(const ContactFace& face)
{
    return face.count == 2 ? Vector3d((face.corner[1] - face.corner[0]).normalized()) : Vector3d(Vector3d::Zero());
}

/// Adds the corners of the part of a face over another, flat face.
void ShapeRegion::add_over(const ContactFace& flat, const ContactFace& face, bool flat_is_a)
{
    const Vector3d& n = found_.normal;
    const double slope = flat.normal.dot(n);
    const Convex& other = flat_is_a ? b_ : a_;
    const Vector3d out = flat_is_a ? Vector3d(-n) : n, axis = axis_of(face);
    const auto take = [&](const Vector3d& at, FeatureBits of_face, FeatureBits of_flat, int end) {
        const Vector3d q = surface(other, axis, at, out, end);
        const Vector3d from = flat.count ? flat.corner[0] : Vector3d(Vector3d::Zero());
        const double way = flat.normal.dot(from - q) / slope;
        const Vector3d p = q + way * n;
        if (flat_is_a)
            add(p, q, flat.off + face.off, of_flat, of_face);
        else
            add(q, p, flat.off + face.off, of_face, of_flat);
    };
    if (flat.count == 0) { // a half-space's plane
        for (std::uint32_t i = 0; i < face.count; ++i) take(face.corner[i], face.vertex(i), flat.face, i ? 1 : -1);
        return;
    }
    clipped_.find(face, flat, 4 * rounding_);
    for (std::uint32_t i = 0; i < clipped_.count; ++i) {
        const ClippedFace::Corner& c = clipped_.corner[i];
        take(c.at, c.of_face, c.of_flat, c.end);
    }
}

/// Adds the ends of the common part of two segments that lie along each other.
void ShapeRegion::add_along()
{
    const Vector3d p = face_a_.corner[0], u = face_a_.corner[1] - p, q = face_b_.corner[0], v = face_b_.corner[1] - q;
    const double length2 = u.squaredNorm(), width2 = v.squaredNorm();
    if (u.cross(v).squaredNorm() > along_each_other * along_each_other * length2 * width2) return;
    const double from = u.dot(q - p) / length2, to = u.dot(q + v - p) / length2;
    const double low = std::clamp(std::min(from, to), 0.0, 1.0), high = std::clamp(std::max(from, to), 0.0, 1.0);
    if (!(high > low)) return;
    const Vector3d axis_a = axis_of(face_a_), axis_b = axis_of(face_b_);
    for (const double t : {low, high}) {
        const Vector3d on_a = p + t * u;
        const double s = std::clamp(v.dot(on_a - q) / width2, 0.0, 1.0);
        const auto end_of = [](double at) { return at <= 0 ? -1 : at >= 1 ? 1 : 0; };
        const Vector3d of_a = surface(a_, axis_a, on_a, found_.normal, end_of(t)),
                       of_b = surface(b_, axis_b, q + s * v, -found_.normal, end_of(s));
        add(of_a, of_b, 0, face_a_.vertex(t > low), face_b_.vertex(s > 0.5));
    }
}

void ShapeRegion::add_deepest()
{
    Vector3d on_a = found_.on_a, on_b = found_.on_b;
    if (!found_.has_points) { // the support point of B, and the point above it, which is on A if that is wide enough
        on_b = placed_.b_to_a(b_.support(cores_.into_b(-found_.normal)));
        on_a = on_b + (found_.upper - cores_.radius()) * found_.normal;
    }
    add(on_a + a_.radius * found_.normal, on_b - b_.radius * found_.normal, 0, face_a_.face, face_b_.face);
}

void ShapeRegion::add_points()
{
    const double over_a = face_a_.flat() || plane_ ? face_a_.normal.dot(found_.normal) : 0,
                 over_b = face_b_.flat() ? -face_b_.normal.dot(found_.normal) : 0;
    if (std::max(over_a, over_b) >= facing) {
        if (over_a + 0x1p-20 >= over_b)
            add_over(face_a_, face_b_, true);
        else
            add_over(face_b_, face_a_, false);
    } else if (face_a_.count == 2 && face_b_.count == 2) {
        add_along();
    }
}

/// True if the points reach the depth that is certain.
bool ShapeRegion::reaches() const
{
    return !points_.empty() &&
           points_.deepest() >= found_.lower - nearly * std::abs(found_.lower) - 16 * rounding_ - close * size();
}

ManifoldPoint ShapeRegion::point(const FewPoints::Candidate& c) const
{
    const Eigen::Isometry3d& pose = *task_.pose_a;
    return {
        pose * c.on_a, pose * c.on_b, c.depth, c.off + 8 * rounding_, c.of_a, c.of_b, pose.linear() * found_.normal};
}

void ShapeRegion::find(PairWorker& worker, Manifold& manifold)
{
    if (!plane_ && cores_.least() - cores_.radius() > options_.margin + rounding_) return;
    found_ = plane_ ? on_plane() : least_translation(cores_, options_.margin);
    if (found_.beyond || !set_kind(worker)) return;
    find_faces();
    const LeastTranslation found = found_;
    if (!plane_) prefer_face(face_a_, 1), prefer_face(face_b_, -1);
    add_points();
    if (!reaches() && found.normal != found_.normal) found_ = found, points_.clear(), add_points();
    if (!reaches()) add_deepest();
    points_.drop_shallow(-options_.margin - 8 * rounding_);
    ManifoldRegion region{};
    region.kind = kind_ == RegionKind::crossing && holds_other(task_, placed_.b_to_a) ? RegionKind::enclosed : kind_;
    if (options_.measures) measure_region(task_, placed_.b_to_a, points_.chosen(), found_.normal, region);
    region.found = points_.count();
    points_.choose(found_.normal, std::min(options_.points_per_region, options_.points_per_pair));
    region.normal = task_.pose_a->linear() * found_.normal, region.normal_error = found_.normal_error;
    region.depth_lower = kind_ == RegionKind::near ? found_.lower : std::max(found_.lower, 0.0);
    region.depth_upper = std::max(found_.upper, region.depth_lower);
    region.first = static_cast<std::uint32_t>(manifold.points.size()), region.count = points_.count();
    for (const FewPoints::Candidate& c : points_.chosen()) {
        const ManifoldPoint p = point(c);
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
    const auto is_shape = [](const Model* m) { return m->kind() == Kind::polytope || m->kind() == Kind::round; };
    return is_shape(task.b) && (is_shape(task.a) || task.a->kind() == Kind::half_space);
}

void manifold_of_shapes(PairWorker& worker, const PairTask& task, const ManifoldOptions& options, Manifold& manifold)
{
    ShapeRegion(task, options).find(worker, manifold);
}

} // namespace oncollide
