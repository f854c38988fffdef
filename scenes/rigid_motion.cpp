#include <oncollide/scenes/rigid_motion.hpp>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/rigid.hpp>

namespace oncollide {

namespace {

using Eigen::Isometry3d, Eigen::Matrix3d, Eigen::Vector3d;
using Key = RigidMotion::Key;

void check_pose(const std::string& name, const Isometry3d& pose)
{
    constexpr double most = 1e15;
    if (const std::string why = why_not_rigid(pose); !why.empty()) refuse(name, why);
    if (pose.translation().cwiseAbs().maxCoeff() > most)
        refuse(name, fmt::format("the pose is beyond {:g} m from the origin", most));
}

void check_keys(std::span<const Key> keys)
{
    if (keys.size() < 2) refuse("motion", fmt::format("it has {} keys; give at least two", keys.size()));
    for (std::size_t i = 0; i < keys.size(); ++i) {
        const std::string name = fmt::format("motion: key {}", i);
        check_pose(name, keys[i].pose);
        if (!std::isfinite(keys[i].time)) refuse(name, "the time is not finite");
        if (i > 0 && !(keys[i - 1].time < keys[i].time))
            refuse(name,
                   fmt::format("time {} does not come after the time before it, {}", keys[i].time, keys[i - 1].time));
    }
    if (keys.front().time != 0 || keys.back().time != 1)
        refuse("motion", fmt::format("its keys run from time {} to {}; they must run from 0 to 1", keys.front().time,
                                     keys.back().time));
}

/// The rotation by the shorter arc; its axis times its angle.
Vector3d shorter_arc(const Matrix3d& from, const Matrix3d& to)
{
    if (from == to) return Vector3d::Zero();
    constexpr double half_turn = 0x1p-41; // cosine of half the angle
    Eigen::Quaterniond q(Matrix3d(to * from.transpose()));
    q.normalize();
    Eigen::Index largest;
    q.vec().cwiseAbs().maxCoeff(&largest);
    if (std::abs(q.w()) <= half_turn ? q.vec()[largest] < 0 : q.w() < 0) q.coeffs() = -q.coeffs();
    const double sine = q.vec().norm();
    return sine > 0 ? Vector3d(2 * std::atan2(sine, q.w()) / sine * q.vec()) : Vector3d::Zero();
}

} // namespace

RigidMotion::Piece::Piece(const Key& first, const Key& second, MotionPath path)
    : begin(first.time), end(second.time), from(first.pose), to(second.pose), axis(0, 0, 1),
      shift(to.translation() - from.translation()), arm(0, 0, 0), rotation_error(0), position_error(0)
{
    const Vector3d arc = shorter_arc(from.linear(), to.linear());
    angle = arc.norm();
    if (angle > 0) axis = arc / angle;
    if (path == MotionPath::screw && angle > 0) {
        // Turning the arm by the angle moves the origin by `across`.
        const Vector3d across = shift - axis.dot(shift) * axis;
        arm = -0.5 * (across + axis.cross(across) / std::tan(0.5 * angle));
        shift = axis.dot(shift) * axis;
    }
    // The computed end may miss `to`, which need not be exactly rigid.
    const Isometry3d last = pose(1);
    const double far = from.translation().lpNorm<1>() + to.translation().lpNorm<1>() + shift.norm();
    if (angle > 0 || from.linear() != to.linear())
        rotation_error = 0x1p-48 + (last.linear() - to.linear()).norm() * (1 + 0x1p-40);
    position_error = 0x1p-48 * (far + angle * arm.norm()) + (last.translation() - to.translation()).norm();
    if (from.matrix() == to.matrix()) rotation_error = position_error = 0;
}

/// @param share  the share of the piece's duration
Isometry3d RigidMotion::Piece::pose(double share) const
{
    const double turned = share * angle, half = std::sin(0.5 * turned);
    Isometry3d pose = from;
    pose.translation() += share * shift;
    if (turned == 0) return pose;
    pose.linear() = Eigen::AngleAxisd(turned, axis).toRotationMatrix() * from.linear();
    const Vector3d sideways = axis.cross(arm);
    pose.translation() += std::sin(turned) * sideways + 2 * half * half * axis.cross(sideways);
    return pose;
}

RigidMotion::RigidMotion(const Isometry3d& rest) : RigidMotion(rest, rest) {}

RigidMotion::RigidMotion(const Isometry3d& from, const Isometry3d& to, MotionPath path)
{
    check_pose("motion: first pose", from), check_pose("motion: last pose", to);
    pieces_.push_back(Piece({0, from}, {1, to}, path));
}

RigidMotion::RigidMotion(std::span<const Key> keys, MotionPath path)
{
    check_keys(keys);
    for (std::size_t i = 1; i < keys.size(); ++i) pieces_.push_back(Piece(keys[i - 1], keys[i], path));
}

const RigidMotion::Piece& RigidMotion::piece_at(double time) const
{
    return *std::ranges::partition_point(pieces_.begin(), pieces_.end() - 1,
                                         [&](const Piece& p) { return !(time < p.end); });
}

Isometry3d RigidMotion::pose(double time) const
{
    const Piece& p = piece_at(time);
    if (time <= p.begin) return p.from;
    if (time >= p.end) return p.to;
    return p.pose((time - p.begin) / (p.end - p.begin));
}

bool RigidMotion::rests() const
{
    return std::ranges::all_of(pieces_, [](const Piece& p) { return p.from.matrix() == p.to.matrix(); });
}

RigidMotion::State RigidMotion::at(double time) const
{
    const Piece& p = piece_at(time);
    const double duration = p.end - p.begin, share = std::clamp((time - p.begin) / duration, 0.0, 1.0);
    const Vector3d first = p.from.translation() - p.arm;
    return {pose(time),
            Vector3d(first + share * p.shift),
            Vector3d(p.shift / duration),
            Vector3d(p.angle / duration * p.axis),
            p.end,
            p.rotation_error,
            p.position_error};
}

double RigidMotion::travel(double begin, double end, const Vector3d& centre, double radius) const
{
    constexpr double rigid = 1 + 0x1p-18; // poses may be 2^-20 from rigid
    double most = 0;
    for (const Piece& p : pieces_) {
        const double duration = p.end - p.begin, from = std::max(begin, p.begin), to = std::min(end, p.end);
        if (!(from < to) || p.from.matrix() == p.to.matrix()) continue;
        const double share = (to - from) / duration * (1 + 0x1p-50);
        const double off_axis = p.axis.cross(p.arm + p.from.linear() * centre).norm() + radius * rigid;
        most += share * p.shift.norm() + 2 * std::sin(0.5 * std::min(share * p.angle, M_PI)) * off_axis;
        most += 2 * (p.rotation_error * (centre.norm() + radius) + p.position_error);
    }
    return most * rigid;
}

} // namespace oncollide
