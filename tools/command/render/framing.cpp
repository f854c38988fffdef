#include "render/framing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace oncollide::tools {

namespace {

constexpr double border = 1.06; ///< factor by which the view is larger than its contents

constexpr double view_angle = 0.35; ///< like a long lens, so that near parts hide little

} // namespace

Camera camera_from(const Eigen::Vector3d& from, const Eigen::Vector3d& middle, double radius)
{
    return {.eye = middle + from * (radius / std::sin(0.5 * view_angle)), .look_at = middle, .view_angle = view_angle};
}

const std::array<Eigen::Vector3d, 16>& good_sides()
{
    static const auto sides = [] {
        std::array<Eigen::Vector3d, 16> made;
        for (std::size_t k = 0; k < made.size(); ++k) {
            const double turn = (double(k % 8) + 0.35) * std::numbers::pi / 4, height = k < 8 ? 0.45 : 1.1;
            made[k] = Eigen::Vector3d(std::sin(turn), -std::cos(turn), height).normalized();
        }
        return made;
    }();
    return sides;
}

Framing::Framing(int width, int height)
{
    rotated_.eye = {0.45, -1, 0.45}, rotated_.look_at = {0, 0, 0};
    view_ = view_of(rotated_);
    view_.translation().setZero();
    tangent_[1] = std::tan(0.5 * rotated_.view_angle) / border;
    tangent_[0] = tangent_[1] * width / height;
    reach_.fill(-std::numeric_limits<double>::infinity());
}

void Framing::add(const Picture& picture)
{
    for (const Picture::Body& body : picture.bodies)
        for (const Eigen::Vector3d& vertex : body.mesh->vertices) add(body.pose * vertex, 0);
    for (const Picture::Ball& ball : picture.balls) add(ball.centre, ball.radius);
}

void Framing::add(const Eigen::Vector3d& point, double radius)
{
    bounds_.add(point - Eigen::Vector3d::Constant(radius)), bounds_.add(point + Eigen::Vector3d::Constant(radius));
    const Eigen::Vector3d p = view_ * point;
    for (std::size_t axis = 0; axis < 2; ++axis) {
        // The plane through the eye is x = -tangent z; a sphere extends radius * |(1, tangent)| beyond its centre.
        const double slope = tangent_[axis] * p.z(), wide = radius * std::hypot(1, tangent_[axis]);
        const double x = p[Eigen::Index(axis)];
        reach_[2 * axis] = std::max(reach_[2 * axis], x + slope + wide);
        reach_[2 * axis + 1] = std::max(reach_[2 * axis + 1], -x + slope + wide);
    }
}

Camera Framing::camera() const
{
    if (bounds_.empty()) return {};
    // The apex of the pyramid is where the planes of each axis meet, on the axis where this point is farther away.
    Eigen::Vector3d top;
    top.z() = -std::numeric_limits<double>::infinity();
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const double right = reach_[2 * axis], left = reach_[2 * axis + 1];
        top[Eigen::Index(axis)] = 0.5 * (right - left);
        top.z() = std::max(top.z(), 0.5 * (right + left) / tangent_[axis]);
    }
    Camera camera = rotated_;
    camera.eye = view_.inverse() * top;
    // The camera looks at the point straight ahead at the depth of the contents' centre.
    const Eigen::Vector3d back = view_.linear().row(2);
    camera.look_at = camera.eye - back * std::max(back.dot(camera.eye - bounds_.centre()), 1e-9 * bounds_.diagonal());
    return camera;
}

} // namespace oncollide::tools
