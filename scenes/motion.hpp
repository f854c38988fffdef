#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/error.hpp>

namespace oncollide {

// Motions of bodies. Time is measured in frames (a double); the scene starts at frame 0.

/// Stays at its pose.
struct Still {};

/// Passes through keys; before the first and after the last key the body stands still. Positions are interpolated
/// linearly, rotations by slerp along the shorter arc. `time` ascends strictly.
struct Keyed {
    struct Key {
        double time;
        Eigen::Vector3d position;
        Eigen::Quaterniond rotation;
    };
    std::vector<Key> keys;
};

/// Constant velocity (m per frame) and spin (rad per frame about a world axis through the body's origin, from its start
/// pose), reflected at the walls so that the body's origin stays inside them. Closed form: no drift over long runs.
struct Drift {
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    Eigen::Vector3d spin = Eigen::Vector3d::Zero(); ///< axis times rad per frame
    Aabb walls;                                     ///< empty: no walls
};

/// Random walk: at frame f each coordinate gets step * (u01(seed + f, index, axis) - 0.5), then reflects at the walls:
/// p < min becomes 2 min - p, p > max becomes 2 max - p.
struct Jitter {
    double step = 0;
    std::uint64_t seed = 0, index = 0;
    Aabb walls; ///< empty: no walls
};

using Motion = std::variant<Still, Keyed, Drift, Jitter>;

/// Throws Error{bad_data} naming `name` for numbers that are not finite or exceed 1e15, walls with an infinite side, a
/// negative step, no key, keys whose times do not ascend, or a key's quaternion whose length differs from 1 by more
/// than 1e-6.
ONCOLLIDE_API void check_motion(const std::string& name, const Motion& motion);

/// Reads a TUM trajectory: lines `t x y z qx qy qz qw`, t in seconds, `#` comments. Times become frames by
/// `frames_per_second`, counted from the first line. Quaternions are normalised; `warnings` gets a line if a length
/// differed from 1 by more than 1e-6. Throws Error{no_input} or Error{bad_data} with path and line number.
ONCOLLIDE_API Keyed load_tum(const std::filesystem::path& path, double frames_per_second,
                             std::vector<std::string>& warnings);

/// One step of a random walk: moves `position` from frame - 1 to `frame` (>= 1).
ONCOLLIDE_API void jitter_step(const Jitter& motion, std::uint64_t frame, Eigen::Vector3d& position);

/// The pose at frame `time` of a body that started at `start`. Returns `start` for Jitter, which needs its history: use
/// Mover.
ONCOLLIDE_API Eigen::Isometry3d pose_at(const Motion& motion, const Eigen::Isometry3d& start, double time);

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
        double angle;          ///< of the whole piece, 0 or more
        Eigen::Vector3d shift; ///< of the pivot
        Eigen::Vector3d arm;   ///< at `begin`, from the pivot to the body's origin
        double rotation_error, position_error;

        Piece(const Key& first, const Key& second, MotionPath path);
        Eigen::Isometry3d pose(double share) const;
    };
    const Piece& piece_at(double time) const;

    std::vector<Piece> pieces_;
};

} // namespace oncollide
