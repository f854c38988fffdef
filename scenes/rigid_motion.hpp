#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/error.hpp>

namespace oncollide {

/// How a body moves from one pose to the next, at constant speed. Both paths rotate along the shorter arc. Within 2^-40
/// rad of a half turn, both arcs count as equally long: the axis is then the one whose largest component (the first of
/// equal ones) is positive in the world frame.
enum class MotionPath : std::uint8_t {
    linear, ///< the body's origin moves along a straight line
    screw,  ///< every point moves along a helix around one axis, or along a straight line if there is no rotation
};

/// A rigid motion over the time from 0 to 1.
class ONCOLLIDE_API RigidMotion {
public:
    /// A pose that the motion passes through, exactly.
    struct Key {
        double time;
        Eigen::Isometry3d pose;
    };

    /// Stays at the pose.
    RigidMotion(const Eigen::Isometry3d& rest = Eigen::Isometry3d::Identity());
    /// Throws Error{bad_data} for poses that are not rigid, or beyond 1e15 m.
    RigidMotion(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, MotionPath path = MotionPath::linear);
    /// Throws Error{bad_data} also for fewer than two keys, for times that do not ascend, and for keys that do not
    /// begin at 0 and end at 1.
    explicit RigidMotion(std::span<const Key> keys, MotionPath path = MotionPath::linear);

    /// The pose at a time from 0 to 1.
    Eigen::Isometry3d pose(double time) const;
    bool rests() const; ///< true if the body stays at its pose
    /// Upper bound on how far any point of a ball of the body moves from its place at `begin` until any time up to
    /// `end`, for the poses as pose() computes them: |v| dt + 2 r sin(angle / 2), rounded outward.
    /// @param centre, radius  the ball, in the body's frame
    double travel(double begin, double end, const Eigen::Vector3d& centre, double radius) const;

    /// The motion around a time, until its next key. A point x of the body (world frame) moves to pivot + velocity dt
    /// + rotated(x - pivot), where the rotation is by the angle |angular| dt about `angular`. Per unit of time.
    struct State {
        Eigen::Isometry3d pose;
        Eigen::Vector3d pivot, velocity, angular;
        double key;                            ///< time of the next key
        double rotation_error, position_error; ///< bounds: how far the linear part and the origin of pose() may be off
    };
    State at(double time) const;

private:
    struct Piece {
        double begin, end;
        Eigen::Isometry3d from, to;
        Eigen::Vector3d axis;  ///< unit, world frame
        double angle;          ///< rotation angle of the whole piece, 0 or more
        Eigen::Vector3d shift; ///< translation of the pivot
        Eigen::Vector3d arm;   ///< vector from the pivot to the body's origin, at `begin`
        double rotation_error, position_error;

        Piece(const Key& first, const Key& second, MotionPath path);
        Eigen::Isometry3d pose(double share) const;
    };
    const Piece& piece_at(double time) const;

    std::vector<Piece> pieces_;
};

} // namespace oncollide
