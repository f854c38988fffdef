#pragma once
#include <oncollide/narrowphase/pairs/half_space.hpp>
#include <oncollide/pipeline/refine/pair_refiner.hpp>
#include <oncollide/pipeline/results.hpp>

namespace oncollide {

/// B's pose in A's frame, and the largest relative error of lengths there compared with the world; 0 if both poses
/// rotate by quarter turns.
struct PlacedPair {
    RelativePose b_to_a;
    double slack;

    PlacedPair(const Eigen::Isometry3d& pose_a, const Eigen::Isometry3d& pose_b);
    double below(double bound) const { return bound * (1 - slack); }
    double above(double bound) const { return bound * (1 + slack); }
};

/// Upper bound on the relative change of lengths by a pose; 0 for quarter turns.
double stretch(const Eigen::Isometry3d& pose);

/// True if the pair needs no traversal: two shapes, or a half-space and any body.
bool without_walk(const Model& a, const Model& b);

/// Decides such pairs. A half-space becomes the first body, because computations are in its frame.
class DirectPair {
public:
    explicit DirectPair(const PairTask& task);

    /// As NonMeshPairs::exact().
    Finding exact(double clearance) const;
    /// For bodies that do not meet: separate beyond the clearance, or near.
    Finding by_distance(double clearance) const;
    /// As NonMeshPairs::near().
    Finding near(double clearance, double tolerance) const;
    /// As World::distance(); beyond `enough.above` the upper bound is infinite.
    Distance distance(const EnoughDistance& enough) const;

private:
    ConvexMeeting meeting() const;
    Finding compare(double clearance, EnoughDistance enough, ContactKind kind) const;
    ConvexDistance placed_distance(const EnoughDistance& enough) const;

    const PairTask& task_;
    const bool swapped_;
    const PlacedPair placed_;
};

} // namespace oncollide
