#pragma once
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/pairs/pair_memory.hpp>
#include <oncollide/narrowphase/walks/swept_motion.hpp>
#include <oncollide/scenes/rigid_motion.hpp>

namespace oncollide {

/// Two moving bodies.
struct SweepTask {
    Model *a, *b;
    const RigidMotion *motion_a, *motion_b;
    SweepOptions options{};
    double clearance = 0;     ///< metres
    bool solid = false;       ///< the inside of a closed mesh belongs to the mesh
    bool other_order = false; ///< this is the same task with its bodies swapped
    double until = 1;         ///< the search ends as soon as no earlier contact is possible
    /// Only the bound `clear_until` is wanted, for one window or up to the first window in which the bodies may meet;
    /// the bodies have no contact at time 0.
    bool bound_only = false;
    bool parts_by_poses = false; ///< parts that meet at time 0 must not depend on hints either; costs a decision
    // Hints: results do not depend on them, except for parts that meet at time 0.
    bool begins_apart = false;    ///< the bodies are probably apart, so a window is examined before the poses at time 0
    PairMemory* memory = nullptr; ///< witnesses of a pose that is probably near; set by a contact at time 0
};

/// A body during a window of time.
struct MovingBody {
    Model& model;
    RigidMotion::State state; ///< in the middle of the window
    Eigen::Vector3d centre;   ///< centre of a ball around the body, in the middle of the window, world frame; unused
                              ///< for a half-space
    double radius;            ///< radius of the ball; 0 for a half-space
};

/// Both bodies from `begin` to `end`, between keys of their motions.
class MotionWindow {
public:
    MotionWindow(const SweepTask& task, double begin, double end, const NearTouch& touch = {});
    double begin() const { return begin_; }
    double end() const { return end_; }
    /// The time at a share from -1 to 1.
    double time(double share) const { return begin_ + 0.5 * (1 + share) * (end_ - begin_); }
    const MovingBody& body(bool a) const { return a ? a_ : b_; }
    /// The motions in the frame of the first body, in the middle of the window.
    /// @param swap  the first body is the task's b
    SweptMotion motion(bool swap) const;

private:
    const SweepTask& task_;
    double begin_, end_;
    NearTouch touch_;
    MovingBody a_, b_;
};

/// The motion of a half-space counts where the other body is.
inline bool is_plane(const MovingBody& body)
{
    return body.model.kind() == Kind::half_space;
}
MovingBody moving_body(Model& model, const RigidMotion& motion, double time);

/// How deep parts may be in each other during a graze that begins at a time.
NearTouch graze_of(const SweepTask& task, double time);

} // namespace oncollide
