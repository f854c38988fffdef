#include <oncollide/narrowphase/pairs/manifolds/shapes/contact_points.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

namespace oncollide {

using Eigen::Vector3d;

namespace {

/// The direction of a segment, unit; 0 for other faces.
Vector3d axis_of(const ContactFace& face)
{
    return face.count == 2 ? Vector3d((face.corner[1] - face.corner[0]).normalized()) : Vector3d(Vector3d::Zero());
}

/// The part of a direction across an axis, unit; 0 if the direction lies along the axis.
Vector3d across_axis(const Vector3d& out, const Vector3d& axis)
{
    Vector3d across = out - axis.dot(out) * axis;
    if (!(across.norm() > 0x1p-40)) return Vector3d::Zero();
    across.normalize(), across -= axis.dot(across) * axis; // again: a short vector has its rounding along the axis
    return across.normalized();
}

/// The point of the surface at a point of the core. A segment's surface is a cylinder around it, and a ball at its
/// ends.
/// @param end  1 or -1: `at` is the end of a segment along its axis, or against it
Vector3d surface_point(const Convex& c, const Vector3d& axis, const Vector3d& at, const Vector3d& out, int end)
{
    if (c.radius == 0) return at;
    const double along = axis.dot(out);
    if (axis.isZero(0) || end * along > 0) return at + c.radius * out;
    return at + c.radius * across_axis(out, axis);
}

/// A flat round face, of which a ContactFace has eight corners.
struct Rim {
    Vector3d centre;
    double radius;
};

std::optional<Rim> rim_of(const ContactFace& face)
{
    if (!face.flat() || !face.rounded) return {};
    const Vector3d &p = face.corner[0], &q = face.corner[face.count / 2];
    return Rim{(p + q) / 2, (p - q).norm() / 2};
}

/// The point of a face, which is flat, on the line along a direction through p.
Vector3d lifted(const Vector3d& p, const ContactFace& face, const Vector3d& along)
{
    return p + face.normal.dot(face.corner[0] - p) / face.normal.dot(along) * along;
}

/// The point of a flat face that is nearest to p, seen along a direction, if p is not over the polygon of its corners.
Vector3d nearest_of(const ContactFace& face, const Vector3d& p, const Vector3d& along)
{
    const auto across = [&](const Vector3d& v) { return Vector3d(v - along.dot(v) * along); };
    if (const std::optional<Rim> rim = rim_of(face)) {
        const Vector3d to = lifted(p, face, along) - rim->centre;
        const double far = to.norm();
        return rim->centre + std::min(1.0, rim->radius / far) * to;
    }
    Vector3d best = face.corner[0];
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t k = 0; k < face.count; ++k) {
        const Vector3d from = face.corner[k], way = face.corner[k + 1 < face.count ? k + 1 : 0] - from;
        const Vector3d seen = across(way), to = across(p - from);
        const double length2 = seen.squaredNorm(), t = length2 > 0 ? std::clamp(seen.dot(to) / length2, 0.0, 1.0) : 0;
        if (const double here = (to - t * seen).squaredNorm(); here < least) least = here, best = from + t * way;
    }
    return best;
}

/// A face of a rounded core on the surface: a segment becomes a line of the cylinder around it.
/// @param out  from the solid to the other body, unit
void to_surface(ContactFace& face, const Convex& solid, const Vector3d& out)
{
    if (solid.radius == 0) return;
    const Vector3d across = face.count < 2 ? out : across_axis(out, axis_of(face));
    for (std::uint32_t k = 0; k < face.count; ++k) face.corner[k] += solid.radius * across;
    if (across.isZero(0)) face.count = 0; // the segment stands: only its end meets the other body
}

} // namespace

Vector3d surface_at(const Convex& c, const Vector3d& axis, double height, const Vector3d& at, const Vector3d& out,
                    double rounding)
{
    const double half = 0.5 * (c.high.z() - c.low.z()), near = half * (1 - 0x1p-30) - 16 * rounding;
    if (c.radius == 0 || c.low == c.high) return at + c.radius * out;
    // Where the direction leads along the segment, the ball at its end is the surface, not the cylinder around it.
    const double along = axis.dot(out), end = std::copysign(half, along);
    const double to_ball = c.radius * (1 - std::sqrt(std::max(1 - along * along, 0.0)));
    if (near <= 0 || std::abs(end - height) < to_ball) // or rounding hides where on the segment the point is
        return at + (end - height) * axis + c.radius * out;
    return surface_point(c, axis, at, out, height >= near ? 1 : height <= -near ? -1 : 0);
}

void ContactPoints::add(const Vector3d& on_a, const Vector3d& on_b, double off, FeatureBits of_a, FeatureBits of_b)
{
    const double depth = normal.dot(on_a - on_b);
    const Vector3d there = on_a - depth * normal;
    points.add({on_a, there, depth, off + (there - on_b).norm(), of_a, of_b});
}

void ContactPoints::add_over(const ContactFace& flat, const ContactFace& face, const Convex& solid, bool flat_is_a,
                             double rounding)
{
    const double slope = flat.normal.dot(normal);
    const Vector3d out = flat_is_a ? Vector3d(-normal) : normal;
    const Vector3d from = flat.count ? flat.corner[0] : Vector3d(Vector3d::Zero());
    // Next to the tip of a needle, the clipped part may extend far beyond.
    const auto beyond = [&](const ContactFace& f) { return f.sharp > 2 ? f.sharp * rounding : 0; };
    const double off = flat.off + face.off + beyond(flat) + beyond(face);
    const auto take = [&](const Vector3d& q, FeatureBits of_face, FeatureBits of_flat) {
        const Vector3d p = q + flat.normal.dot(from - q) / slope * normal;
        if (flat_is_a)
            add(p, q, off, of_flat, of_face);
        else
            add(q, p, off, of_face, of_flat);
    };
    const auto take_all = [&](const ContactFace& on_surface) {
        if (flat.count == 0) {
            for (std::uint32_t i = 0; i < on_surface.count; ++i)
                take(on_surface.corner[i], on_surface.vertex(i), flat.face);
            return;
        }
        if (on_surface.count == 0) return;
        clipped_.find(on_surface, flat, -out, rounding);
        for (std::uint32_t i = 0; i < clipped_.count; ++i)
            take(clipped_.corner[i].at, clipped_.corner[i].of_face, clipped_.corner[i].of_flat);
    };
    if (solid.radius == 0) {
        const std::uint32_t before = points.count();
        take_all(face);
        if (points.count() > before || !flat.flat() || !face.flat() || std::abs(face.normal.dot(normal)) < 0.5) return;
        // A rim reaches beyond its corners' polygon: up to the point of the other face that is nearest to its centre.
        const std::optional<Rim> of_face = rim_of(face), of_flat = rim_of(flat);
        if (!of_face && !of_flat) return;
        const Rim& rim = of_face ? *of_face : *of_flat;
        const Vector3d there = nearest_of(of_face ? flat : face, rim.centre, normal),
                       here = lifted(there, of_face ? face : flat, normal);
        if ((here - rim.centre).norm() <= rim.radius + rounding) take(of_face ? here : there, face.face, flat.face);
        return;
    }
    surface_ = face;
    to_surface(surface_, solid, out);
    take_all(surface_);
    if (face.count < 2) return;
    // The end that leads is a ball, which reaches farther than the line.
    const unsigned leads = (face.corner[1] - face.corner[0]).dot(out) > 0;
    surface_.count = 1, surface_.corner[0] = face.corner[leads] + solid.radius * out;
    surface_.number[0] = face.number[leads];
    take_all(surface_);
}

void ContactPoints::add_along(const ContactFace& face_a, const Convex& a, const ContactFace& face_b, const Convex& b)
{
    const Vector3d p = face_a.corner[0], u = face_a.corner[1] - p, q = face_b.corner[0], v = face_b.corner[1] - q;
    const double length2 = u.squaredNorm(), width2 = v.squaredNorm();
    if (u.cross(v).squaredNorm() > along_each_other * along_each_other * length2 * width2) return;
    const double from = u.dot(q - p) / length2, to = u.dot(q + v - p) / length2;
    const double low = std::clamp(std::min(from, to), 0.0, 1.0), high = std::clamp(std::max(from, to), 0.0, 1.0);
    if (!(high > low)) return;
    const Vector3d axis_a = axis_of(face_a), axis_b = axis_of(face_b);
    for (const double t : {low, high}) {
        const Vector3d on_a = p + t * u;
        const double s = std::clamp(v.dot(on_a - q) / width2, 0.0, 1.0);
        const auto end_of = [](double at) { return at <= 0 ? -1 : at >= 1 ? 1 : 0; };
        const Vector3d of_a = surface_point(a, axis_a, on_a, normal, end_of(t)),
                       of_b = surface_point(b, axis_b, q + s * v, -normal, end_of(s));
        add(of_a, of_b, 0, face_a.vertex(t > low), face_b.vertex(s > 0.5));
    }
}

} // namespace oncollide
