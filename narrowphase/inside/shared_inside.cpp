#include <oncollide/narrowphase/inside/shared_inside.hpp>

#include <algorithm>
#include <cmath>

#include <oncollide/narrowphase/exact/common_corner.hpp>
#include <oncollide/narrowphase/inside/corner_fans.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

double largest(const TrianglePoints& t)
{
    return std::max({t[0].cwiseAbs().maxCoeff(), t[1].cwiseAbs().maxCoeff(), t[2].cwiseAbs().maxCoeff()});
}

Vector3d unit_normal_of(const TrianglePoints& t)
{
    return (t[1] - t[0]).stableNormalized().cross((t[2] - t[0]).stableNormalized()).stableNormalized();
}

constexpr double lean = 0x1p-10; ///< tangent of the angle between a step and the face

/// A step far larger than the error of a contact's position.
double step_of(double length, double far)
{
    return std::max(0x1p-20 * length, 0x1p-34 * far);
}

/// Points next to a contact that is a point, on both sides of the triangle: if the surfaces meet only there, all of a
/// face around it is on one side of the other mesh.
void beside_point(const Vector3d& contact, const TrianglePoints& t, double far, std::vector<Vector3d>& points)
{
    const Vector3d inward = (t[0] + t[1] + t[2]) / 3 - contact;
    const double length = inward.stableNorm();
    if (!(length > 0)) return;
    for (const double side : {lean, -lean})
        points.push_back(contact + step_of(length, far) * (inward / length + side * unit_normal_of(t)));
}

/// The same array for the ends in either order.
std::array<double, 6> as_array(const std::array<Vector3d, 2>& ends)
{
    const auto& [p, q] = ends;
    const std::array<double, 6> there{p.x(), p.y(), p.z(), q.x(), q.y(), q.z()},
        back{q.x(), q.y(), q.z(), p.x(), p.y(), p.z()};
    return std::min(there, back);
}

/// A point of the face near a contact that is a point.
Vector3d in_face(const Vector3d& contact, const TrianglePoints& t, double far)
{
    const Vector3d inward = (t[0] + t[1] + t[2]) / 3 - contact;
    const double length = inward.stableNorm();
    return contact + step_of(length, far) * (inward / length);
}

/// Points next to a contact that is a segment, on both sides of the triangle and of the contact.
void beside_segment(const std::array<Vector3d, 2>& ends, const TrianglePoints& t, double far,
                    std::vector<Vector3d>& points)
{
    const Vector3d along = ends[1] - ends[0], middle = ends[0] + 0.5 * along;
    const double length = along.stableNorm(), step = step_of(length, far);
    const Vector3d up = unit_normal_of(t), in_face = up.cross(along / length);
    for (const double way : {step, -step})
        for (const double side : {lean, -lean}) points.push_back(middle + way * (in_face + side * up));
}

/// Clears the flags of corners on a triangle of the other mesh that meets this one along a segment: the points next to
/// the segment cover them.
void leave_out_corners_on(const TrianglePoints& other, const TrianglePoints& t, std::uint8_t& flags)
{
    for (std::size_t i = 0; i < 3; ++i)
        if ((flags >> i & 1) && triangles_meet({t[i], t[i], t[i]}, other))
            flags = static_cast<std::uint8_t>(flags & ~(1u << i));
}

} // namespace

TrianglePoints SharedInside::corners(const Side& side, std::uint32_t triangle)
{
    const Mesh& mesh = side.tree->mesh();
    const Triangle& t = mesh.triangles[triangle];
    return {side.to_a(mesh.vertices[t[0]]), side.to_a(mesh.vertices[t[1]]), side.to_a(mesh.vertices[t[2]])};
}

bool SharedInside::inside(const Side& side, const Vector3d& point)
{
    ++placed_;
    return locator_.place(point, side.tree->mesh(), side.tree, side.to_a) == PointLocation::inside;
}

SharedInside::Side SharedInside::first(ObbTree& a)
{
    return {&a, RelativePose(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity())};
}

std::optional<Vector3d> SharedInside::beside_corners(const Side& side, const std::vector<std::uint8_t>& flags,
                                                     const Side& other)
{
    const Mesh& mesh = side.tree->mesh();
    const std::vector<FanCorner> fans = fans_of(mesh, flags);
    enum : std::uint8_t { unknown, in, out };
    std::vector<std::uint8_t> place(fans.size(), unknown); // place of each fan in the other mesh
    for (const auto& [t, corner, fan] : fans) {
        const TrianglePoints points = corners(side, t);
        const double far = largest(points);
        if (place[fan] == unknown) place[fan] = inside(other, in_face(points[corner], points, far)) ? in : out;
        if (place[fan] == out) continue;
        points_.clear();
        beside_point(points[corner], points, far, points_);
        for (const Vector3d& point : points_)
            if (inside(side, point) && inside(other, point)) return point;
    }
    return std::nullopt;
}

void SharedInside::set_points_beside(const Side& side_a, const Side& side_b, TrianglePair pair)
{
    const TrianglePoints here = corners(side_a, pair.a), moved = corners(side_b, pair.b);
    const auto ends = common_segment(here, moved).ends;
    // Rounded up to a power of two, so that the points tried around a contact do not depend on the other triangle.
    const double far = std::exp2(std::ceil(std::log2(std::max(largest(here), largest(moved)))));
    const bool is_point = !((ends[1] - ends[0]).stableNorm() > 0x1p-40 * far);
    points_.clear();
    for (const int side : {0, 1}) {
        const TrianglePoints& t = side ? moved : here;
        if (!seen_.emplace(side, side ? pair.b : pair.a, as_array(ends), far).second) continue;
        if (is_point)
            beside_point(ends[0], t, far, points_);
        else
            beside_segment(ends, t, far, points_);
    }
}

bool SharedInside::is_beside(ObbTree& a, ObbTree& b, const RelativePose& b_to_a, TrianglePair pair)
{
    const Side side_a = first(a), side_b{&b, b_to_a};
    if (only_common_corner(corners(side_a, pair.a), corners(side_b, pair.b))) return false;
    seen_.clear();
    set_points_beside(side_a, side_b, pair);
    return std::ranges::any_of(points_, [&](const Vector3d& p) { return inside(side_a, p) && inside(side_b, p); });
}

std::optional<Vector3d> SharedInside::find(ObbTree& a, ObbTree& b, const RelativePose& b_to_a, bool not_parted)
{
    placed_ = 0;
    if (!not_parted && walk_.contact(a, b, b_to_a).parted) return std::nullopt;
    const Side side_a = first(a), side_b{&b, b_to_a};
    walk_.all_meeting(a, b, b_to_a, contacts_, corners_);
    for (const auto& [of_a, of_b] : contacts_) {
        if (!corners_.of_a[of_a] && !corners_.of_b[of_b]) continue;
        const TrianglePoints here = corners(side_a, of_a), moved = corners(side_b, of_b);
        leave_out_corners_on(moved, here, corners_.of_a[of_a]), leave_out_corners_on(here, moved, corners_.of_b[of_b]);
    }
    if (const auto point = beside_corners(side_a, corners_.of_a, side_b)) return point;
    if (const auto point = beside_corners(side_b, corners_.of_b, side_a)) return point;
    seen_.clear();
    for (const TrianglePair& pair : contacts_) {
        set_points_beside(side_a, side_b, pair);
        for (const Vector3d& point : points_)
            if (inside(side_a, point) && inside(side_b, point)) return point;
    }
    return std::nullopt;
}

} // namespace oncollide
