#include <oncollide/narrowphase/exact/shared_inside.hpp>

#include <algorithm>

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

/// Points beside a contact that is a point, on both sides of both triangles: where surfaces meet there alone, all of a
/// face around it is on one side of the other mesh.
std::vector<Vector3d> beside_point(const Vector3d& contact, const TrianglePoints& a, const TrianglePoints& b,
                                   double far)
{
    std::vector<Vector3d> points;
    for (const TrianglePoints* t : {&a, &b}) {
        const Vector3d inward = ((*t)[0] + (*t)[1] + (*t)[2]) / 3 - contact;
        const double length = inward.stableNorm();
        if (!(length > 0)) continue;
        for (const double side : {lean, -lean})
            points.push_back(contact + step_of(length, far) * (inward / length + side * unit_normal_of(*t)));
    }
    return points;
}

/// Points beside the contact of two triangles, on both sides of both of them and of the contact.
std::vector<Vector3d> beside(const TrianglePoints& a, const TrianglePoints& b)
{
    const auto [ends, kind] = common_segment(a, b);
    const Vector3d along = ends[1] - ends[0];
    const double length = along.stableNorm(), far = std::max(largest(a), largest(b));
    if (!(length > 0x1p-40 * far)) return beside_point(ends[0], a, b, far);
    const Vector3d middle = ends[0] + 0.5 * along, unit = along / length;
    const double step = step_of(length, far);
    std::vector<Vector3d> points;
    for (const TrianglePoints* t : {&a, &b}) {
        const Vector3d up = unit_normal_of(*t), in_face = up.cross(unit);
        for (const double way : {step, -step})
            for (const double side : {lean, -lean}) points.push_back(middle + way * (in_face + side * up));
    }
    return points;
}

TrianglePoints corners(const Mesh& mesh, std::uint32_t triangle)
{
    const Triangle& t = mesh.triangles[triangle];
    return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

} // namespace

std::optional<Vector3d> SharedInside::find(ObbTree& a, ObbTree& b, const RelativePose& b_to_a)
{
    const RelativePose stay(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity());
    walk_.all_meeting(a, b, b_to_a, contacts_);
    for (const auto& [of_a, of_b] : contacts_) {
        TrianglePoints moved = corners(b.mesh(), of_b);
        for (Vector3d& p : moved) p = b_to_a(p);
        for (const Vector3d& point : beside(corners(a.mesh(), of_a), moved))
            if (locator_.place(point, a.mesh(), &a, stay) == PointPlace::inside &&
                locator_.place(point, b.mesh(), &b, b_to_a) == PointPlace::inside)
                return point;
    }
    return std::nullopt;
}

} // namespace oncollide
