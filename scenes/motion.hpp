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
#include <oncollide/scenes/rigid_motion.hpp>

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

/// Moves one body, as Mover does, from its pose at frame `from` to its pose at `to`; ignores recordings.
/// @param pose  in: the pose at `from`, read for Jitter only; out: the pose at `to`
ONCOLLIDE_API void move_body(const Motion& motion, const Eigen::Isometry3d& start, double pace, int from, int to,
                             Eigen::Isometry3d& pose);

/// The way of a body from `first`, its pose at time `from`, to `last` at time `to`: straight and along the shorter arc,
/// but through the keys of a Keyed motion between the two times. Times are times of the motion: frames times pace.
/// Empty if the body stays at its pose.
ONCOLLIDE_API std::vector<RigidMotion::Key> way_between(const Motion& motion, double from, double to,
                                                        const Eigen::Isometry3d& first, const Eigen::Isometry3d& last);

} // namespace oncollide
