#pragma once
#include <oncollide/narrowphase/shapes/half_space.hpp>
#include <oncollide/pipeline/contacts.hpp>
#include <oncollide/pipeline/refine/pair_refiner.hpp>

namespace oncollide {

/// Where B is in A's frame, and by how much lengths there may differ from the world's, relative: 0 where both poses
/// turn by quarters.
struct PlacedPair {
    RelativePose b_to_a;
    double slack;

    PlacedPair(const Eigen::Isometry3d& pose_a, const Eigen::Isometry3d& pose_b);
    double below(double bound) const { return bound * (1 - slack); }
    double above(double bound) const { return bound * (1 + slack); }
};

/// By how much a pose makes lengths longer or shorter at most, relative; 0 of quarter turns.
double stretch(const Eigen::Isometry3d& pose);

/// Is the pair decided without a walk: two shapes, or a half-space and anything?
bool without_walk(const Model& a, const Model& b);

/// What decides such pairs. A half-space comes first, then its frame is the one that counts.
class DirectPair {
public:
    explicit DirectPair(const PairTask& task);

    /// As NonMeshPairs::exact().
    RefineResult exact(double clearance) const;
    /// Separate beyond the clearance, or near, where they do not meet.
    RefineResult by_distance(double clearance) const;
    /// As NonMeshPairs::near().
    RefineResult near(double clearance, double tolerance) const;
    /// As World::distance(); of shapes that are farther apart than `enough.above` the upper bound is infinite.
    Distance distance(const EnoughDistance& enough) const;

private:
    ConvexMeeting meeting() const;
    RefineResult compare(double clearance, EnoughDistance enough, ContactKind kind) const;
    ConvexDistance placed_distance(const EnoughDistance& enough) const;

    const PairTask& task_;
    const bool swapped_;
    const PlacedPair placed_;
};

} // namespace oncollide
