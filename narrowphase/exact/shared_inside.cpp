#include <oncollide/narrowphase/exact/shared_inside.hpp>

#include <algorithm>
#include <cmath>

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

constexpr double lean = 0x1p-10; ///< away from a face

/// A step far larger than what a contact's place errs by.
double step_of(double length, double far)
{
    return std::max(0x1p-20 * length, 0x1p-34 * far);
}

/// Points beside a contact that is a point, on both sides of the triangle: where surfaces meet there alone, all of a
/// face around it is on one side of the other mesh.
void beside_point(const Vector3d& contact, const TrianglePoints& t, double far, std::vector<Vector3d>& points)
{
    const Vector3d inward = (t[0] + t[1] + t[2]) / 3 - contact;
    const double length = inward.stableNorm();
    if (!(length > 0)) return;
    for (const double side : {lean, -lean})
        points.push_back(contact + step_of(length, far) * (inward / length + side * unit_normal_of(t)));
}

/// Points beside a contact that is a segment, on both sides of the triangle and of the contact.
void beside_segment(const std::array<Vector3d, 2>& ends, const TrianglePoints& t, double far,
                    std::vector<Vector3d>& points)
{
    const Vector3d along = ends[1] - ends[0], middle = ends[0] + 0.5 * along;
    const double length = along.stableNorm(), step = step_of(length, far);
    const Vector3d up = unit_normal_of(t), in_face = up.cross(along / length);
    for (const double way : {step, -step})
        for (const double side : {lean, -lean}) points.push_back(middle + way * (in_face + side * up));
}

TrianglePoints corners(const Mesh& mesh, std::uint32_t triangle)
{
    const Triangle& t = mesh.triangles[triangle];
    return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

} // namespace

std::optional<Vector3d> SharedInside::find(ObbTree& a, ObbTree& b, const RelativePose& b_to_a)
{
    placed_ = 0;
    if (walk_.contact(a, b, b_to_a).parted) return std::nullopt;
    const RelativePose stay(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity());
    const auto shared = [&](const Vector3d& point) {
        ++placed_;
        return locator_.place(point, a.mesh(), &a, stay) == PointPlace::inside &&
               locator_.place(point, b.mesh(), &b, b_to_a) == PointPlace::inside;
    };
    walk_.all_meeting(a, b, b_to_a, contacts_);
    seen_.clear();
    for (const auto& [of_a, of_b] : contacts_) {
        TrianglePoints moved = corners(b.mesh(), of_b);
        for (Vector3d& p : moved) p = b_to_a(p);
        const TrianglePoints here = corners(a.mesh(), of_a);
        const auto ends = common_segment(here, moved).ends;
        // Rounded up to a power of two, so that what is tried around a point does not depend on the other triangle.
        const double far = std::exp2(std::ceil(std::log2(std::max(largest(here), largest(moved)))));
        const bool is_point = !((ends[1] - ends[0]).stableNorm() > 0x1p-40 * far);
        points_.clear();
        for (const int side : {0, 1}) {
            const TrianglePoints& t = side ? moved : here;
            const Vector3d& at = ends[0];
            if (!is_point)
                beside_segment(ends, t, far, points_);
            else if (seen_.emplace(side, side ? of_b : of_a, at.x(), at.y(), at.z(), far).second)
                beside_point(at, t, far, points_);
        }
        for (const Vector3d& point : points_)
            if (shared(point)) return point;
    }
    return std::nullopt;
}

} // namespace oncollide
