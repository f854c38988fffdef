#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/aabb.hpp>

namespace oncollide {

// How a body moves. Time is counted in frames (a double), frame 0 being the scene's start.

/// Stays at its pose.
struct Still {};

/// Passes through keys; before the first and after the last key it stands. Positions linear, rotations by slerp along
/// the shorter arc. `time` ascends strictly.
struct Keyed {
    struct Key {
        double time;
        Eigen::Vector3d position;
        Eigen::Quaterniond rotation;
    };
    std::vector<Key> keys;
};

/// Constant velocity (m a frame) and spin (rad a frame about a world axis through the body's origin, from its start
/// pose), reflected at the walls: the body's origin stays inside them. Closed form: no drift over long runs.
struct Drift {
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    Eigen::Vector3d spin = Eigen::Vector3d::Zero(); ///< axis times rad a frame
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

/// Throws Error{bad_data} naming `name`: numbers that are not finite or exceed 1e15, walls with an infinite side, a
/// negative step, no key, keys whose times do not ascend, a key's quaternion whose length is off 1 by more than 1e-6.
void check_motion(const std::string& name, const Motion& motion);

/// Reads a TUM trajectory: lines `t x y z qx qy qz qw`, t in seconds, `#` comments. Times become frames by
/// `frames_per_second`, counted from the first line. Quaternions are normalised; `warnings` gets a line when one was
/// off by more than 1e-6. Throws Error{no_input} or Error{bad_data} with path and line number.
Keyed load_tum(const std::filesystem::path& path, double frames_per_second, std::vector<std::string>& warnings);

/// One step of a random walk: moves `position` from frame - 1 to `frame` (>= 1).
void jitter_step(const Jitter& motion, std::uint64_t frame, Eigen::Vector3d& position);

/// The pose at frame `time` of a body that started at `start`. Jitter gives `start`: use Mover, it needs its history.
Eigen::Isometry3d pose_at(const Motion& motion, const Eigen::Isometry3d& start, double time);

} // namespace oncollide
