#include <oncollide/narrowphase/pairs/motion_window.hpp>

#include <algorithm>
#include <limits>

#include <oncollide/narrowphase/pairs/placed_pair.hpp>

namespace oncollide {

using Eigen::Vector3d;

MovingBody moving_body(Model& model, const RigidMotion& motion, double time)
{
    const RigidMotion::State state = motion.at(time);
    if (model.kind() == Kind::half_space) return {model, state, state.pose.translation(), 0};
    const Aabb box = bounds_of(model.geometry());
    return {model, state, state.pose * box.centre(), box.half_extent().norm() * (1 + 0x1p-18)};
}

namespace {

/// How far the body may be from its linear motion over half a window of duration 2 * half, besides rotation about a
/// point of it: the centrifugal acceleration, and the error of its poses.
double bend(const MovingBody& body, double half)
{
    const double angle = half * body.state.angular.norm();
    double off = 2 * body.state.position_error;
    if (angle > 0) {
        const Vector3d arm = body.centre - body.state.pivot;
        const double off_axis = body.state.angular.cross(arm).norm() / body.state.angular.norm() + body.radius;
        off += 0.5 * angle * angle * off_axis;
    }
    if (body.state.rotation_error > 0)
        off += 2 * body.state.rotation_error * (body.radius + (body.centre - body.state.pose.translation()).norm());
    return off * (1 + 0x1p-20);
}

} // namespace

MotionWindow::MotionWindow(const SweepTask& task, double begin, double end, const NearTouch& touch)
    : task_(task), begin_(begin), end_(end), touch_(touch),
      a_(moving_body(*task.a, *task.motion_a, 0.5 * (begin + end))),
      b_(moving_body(*task.b, *task.motion_b, 0.5 * (begin + end)))
{
}

SweptMotion MotionWindow::motion(bool swap) const
{
    const MovingBody &first = swap ? b_ : a_, &second = swap ? a_ : b_;
    const double half = 0.5 * (end_ - begin_);
    const Eigen::Matrix3d into = first.state.pose.linear().transpose();
    const Vector3d origin = first.state.pose.translation();
    const auto side = [&](const RigidMotion::State& state) {
        const Vector3d at_origin = state.velocity + state.angular.cross(origin - state.pivot);
        return SweptSide{half * (into * at_origin), half * (into * state.angular)};
    };
    SweptMotion motion{side(first.state), side(second.state), task_.clearance + bend(a_, half) + bend(b_, half),
                       touch_};
    // Poses that are not quite rigid turn motions by slightly different angles.
    const double stretched = stretch(first.state.pose) + stretch(second.state.pose);
    const double turned = half * ((first.state.angular.norm() + second.state.angular.norm()) *
                                  (first.radius + second.radius + (first.centre - second.centre).norm()));
    const double far = a_.centre.norm() + b_.centre.norm() + a_.radius + b_.radius;
    motion.slack += 2 * stretched * (turned + half * (first.state.velocity - second.state.velocity).norm());
    motion.slack += 0x1p-48 * (far + motion.a.shift.norm() + motion.b.shift.norm());
    // Round solids have other sizes in such frames; for other bodies the bounds of the tests allow for it.
    if (touch_.careful) motion.slack += stretched * (first.radius + second.radius);
    return motion;
}

NearTouch graze_of(const SweepTask& task, double time)
{
    constexpr double no_bound = std::numeric_limits<double>::infinity();
    const MotionWindow window(task, time, time);
    const MovingBody &a = window.body(true), &b = window.body(false);
    // Bodies that are thinner than the depth could pass each other.
    const auto thickness = [](const MovingBody& body) {
        return is_plane(body) ? no_bound : bounds_of(body.model.geometry()).half_extent().minCoeff();
    };
    const auto radius = [](const MovingBody& body) { return is_plane(body) ? no_bound : body.radius; };
    const double thick = 0.25 * std::max(thickness(a), thickness(b)), wide = 0.125 * std::min(radius(a), radius(b));
    const double size = task.a->reach() + task.b->reach() + (a.centre - b.centre).norm();
    const double rounding = 8 * (window.motion(false).slack - task.clearance + 0x1p-44 * size);
    const double tolerance = task.options.gap_tolerance;
    return {true, std::max({std::min({0.5 * tolerance, thick, wide}), 0x1p-10 * tolerance, rounding})};
}

} // namespace oncollide
