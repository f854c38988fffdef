#pragma once
#include <utility>

#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/pairs/pair_task.hpp>

namespace oncollide {

/// B's pose in A's frame, and the largest relative error of lengths there compared with the world; 0 if both poses
/// rotate by quarter turns.
struct PlacedPair {
    RelativePose b_to_a;
    double slack;

    PlacedPair(const Eigen::Isometry3d& pose_a, const Eigen::Isometry3d& pose_b);
    PlacedPair(const Eigen::Isometry3d& pose_a, const Eigen::Isometry3d& pose_b, double slack_of_both)
        : b_to_a(pose_a, pose_b), slack(slack_of_both)
    {
    }
    explicit PlacedPair(const PairTask& task);
    double below(double bound) const { return bound * (1 - slack); }
    double above(double bound) const { return bound * (1 + slack); }
};

/// True if exact decisions take b first, in whose frame they compute. It depends on the bodies alone, and not on which
/// of them is called a: rounding in another frame could give another result.
bool decides_b_first(const PairTask& task);

/// Upper bound on the relative change of lengths by a pose; 0 for quarter turns.
double stretch(const Eigen::Isometry3d& pose);
/// The stretch of both poses.
inline double slack_of(const PairTask& task)
{
    return task.slack >= 0 ? task.slack : stretch(*task.pose_a) + stretch(*task.pose_b);
}

/// Upper bound on the effect of rounding and of not exactly rigid poses on distances of the two bodies.
double rounding_of(const PairTask& task);
/// A traversal returns `separate` for bodies farther apart than this.
/// @param beyond  the cutoff, up to which it may return another verdict
double surely_separate(const PairTask& task, double beyond);

/// The distance of the task's a and b. `swapped`: d is of b and a.
inline Distance in_task(Distance d, bool swapped)
{
    if (swapped) std::swap(d.point_a, d.point_b), std::swap(d.a, d.b);
    return d;
}

/// A pair in the order in which its test takes it: computations are in the first body's frame.
struct OrderedPair {
    Model &a, &b;
    const Eigen::Isometry3d &pose_a, &pose_b;
    PlacedPair placed;
    bool swapped; ///< true: a is the task's b

    OrderedPair(const PairTask& task, bool swap)
        : a(swap ? *task.b : *task.a), b(swap ? *task.a : *task.b), pose_a(swap ? *task.pose_b : *task.pose_a),
          pose_b(swap ? *task.pose_a : *task.pose_b), placed(pose_a, pose_b, slack_of(task)), swapped(swap)
    {
    }
    /// Undoes the swap.
    Distance in_task(const Distance& d) const { return oncollide::in_task(d, swapped); }
    Contact in_task(Contact c) const
    {
        if (swapped) std::swap(c.a, c.b), std::swap(c.ends[0], c.ends[1]), std::swap(c.normal_a, c.normal_b);
        return c;
    }
};

} // namespace oncollide
