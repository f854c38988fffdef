#include <oncollide/robots/spheres/link_surface.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <oncollide/base/numbers/infinity.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>

namespace oncollide {

using Eigen::Vector3d;
using Corners = LinkSurface::Corners;

double area_of(const Corners& t)
{
    return (t[1] - t[0]).cross(t[2] - t[0]).norm() / 2;
}

double longest_edge(const Corners& t)
{
    return std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
}

std::array<Corners, 2> halves_of(const Corners& t)
{
    const double edges[] = {(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()};
    const auto k = static_cast<std::size_t>(std::ranges::max_element(edges) - edges);
    const Vector3d &a = t[k], &b = t[(k + 1) % 3], &c = t[(k + 2) % 3], middle = (a + b) / 2;
    return {Corners{a, middle, c}, Corners{middle, b, c}};
}

namespace {

/// Negative inside. Infinity for a shape that URDF does not have.
double distance_of(const Shape& shape, const Vector3d& p)
{
    const auto outside_box = [](const auto& beyond) { // `beyond` is how far the point is beyond the half sizes
        return beyond.cwiseMax(0).norm() + std::min(beyond.maxCoeff(), 0.0);
    };
    if (const auto* sphere = std::get_if<Sphere>(&shape)) return p.norm() - sphere->radius;
    if (const auto* box = std::get_if<Box>(&shape)) return outside_box(Vector3d(p.cwiseAbs() - box->half));
    const double across = p.head<2>().norm();
    if (const auto* capsule = std::get_if<Capsule>(&shape))
        return std::hypot(across, std::max(0.0, std::abs(p.z()) - capsule->length / 2)) - capsule->radius;
    if (const auto* cylinder = std::get_if<Cylinder>(&shape))
        return outside_box(Eigen::Vector2d(across - cylinder->radius, std::abs(p.z()) - cylinder->length / 2));
    return infinity;
}

} // namespace

LinkSurface::LinkSurface(const RobotLink& link)
{
    Aabb box;
    for (const LinkGeometry& collision : link.collision) {
        const GeometryData& data = collision.geometry->data;
        const Mesh mesh =
            std::holds_alternative<Shape>(data) ? bounding_mesh_of(std::get<Shape>(data)).mesh : std::get<Mesh>(data);
        Part part{triangles_.size(), 0, is_closed(mesh), std::get_if<Shape>(&data), collision.pose.inverse()};
        if (part.shape) shapes_.push_back(collision.geometry);
        for (const Triangle& t : mesh.triangles) {
            Corners corners;
            for (std::size_t k = 0; k < 3; ++k) corners[k] = collision.pose * mesh.vertices[t[k]], box.add(corners[k]);
            area_ += area_of(corners);
            around_.push_back(enclosing_sphere(corners));
            triangles_.push_back(corners);
        }
        part.end = triangles_.size();
        closed_ = closed_ && part.closed;
        parts_.push_back(part);
    }
    if (!triangles_.empty()) size_ = box.diagonal();
}

double LinkSurface::distance_squared(const Vector3d& point, std::size_t first, std::size_t end, Vector3d* nearest) const
{
    double least = infinity;
    for (std::size_t i = first; i < end; ++i) {
        const double to_sphere = (around_[i].centre - point).norm() - around_[i].radius;
        if (to_sphere > 0 && to_sphere * to_sphere >= least) continue;
        const Vector3d at = nearest_on(triangles_[i], point).at;
        if (const double square = (at - point).squaredNorm(); square < least) {
            least = square;
            if (nearest) *nearest = at;
        }
    }
    return least;
}

Vector3d LinkSurface::nearest(const Vector3d& point) const
{
    Vector3d at = point;
    distance_squared(point, 0, triangles_.size(), &at);
    return at;
}

/// Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
double LinkSurface::thickness(const Vector3d& from, const Vector3d& direction) const
{
    double least = size_;
    for (const Corners& t : triangles_) {
        const Vector3d e1 = t[1] - t[0], e2 = t[2] - t[0], h = direction.cross(e2), s = from - t[0];
        const double a = e1.dot(h);
        if (a == 0) continue;
        const double u = s.dot(h) / a, v = direction.dot(s.cross(e1)) / a, along = e2.dot(s.cross(e1)) / a;
        if (u >= 0 && v >= 0 && u + v <= 1 && along > 1e-6 * size_) least = std::min(least, along);
    }
    return least;
}

/// The sum of the solid angles of the triangles: a whole turn for a point inside (van Oosterom and Strackee, 1983).
bool LinkSurface::inside(const Vector3d& point, const Part& part) const
{
    double sum = 0;
    for (std::size_t i = part.first; i < part.end; ++i) {
        const Vector3d a = triangles_[i][0] - point, b = triangles_[i][1] - point, c = triangles_[i][2] - point;
        const double la = a.norm(), lb = b.norm(), lc = c.norm();
        sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    return std::abs(sum) > std::numbers::pi; // a whole turn is 2 pi here, and 0 is outside
}

double LinkSurface::signed_distance(const Vector3d& point) const
{
    double least = infinity;
    for (const Part& part : parts_) {
        const double slack = 1e-12 * (size_ + point.norm());
        if (const double own = part.shape ? distance_of(*part.shape, part.into * point) : HUGE_VAL; own < HUGE_VAL) {
            least = std::min(least, own + slack);
            continue;
        }
        const double distance = std::sqrt(distance_squared(point, part.first, part.end, nullptr));
        // Near the surface rounding may hide the side; the distance is an upper bound there, too.
        const bool deep = distance > 1e-9 * size_ && inside(point, part);
        least = std::min(least, (deep ? -distance : distance) + slack);
    }
    return least;
}

} // namespace oncollide
