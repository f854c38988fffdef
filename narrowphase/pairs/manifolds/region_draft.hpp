#pragma once
#include <array>
#include <vector>

#include <oncollide/narrowphase/pairs/manifolds/key_numbers.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/candidate.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/faces_ahead.hpp>

namespace oncollide {

/// A region before its points are chosen, in the frame of the pair. Keeps its memory.
struct RegionDraft {
    ManifoldRegion region{};
    std::vector<ManifoldCandidate> candidates;          ///< each feature, or pair of features, once
    std::vector<Eigen::Vector3d> contacts;              ///< exact contacts of the region
    std::array<std::vector<NumberedTriangle>, 2> faces; ///< faces of a and of b: where opposite points are
    double rounding = 0;                                ///< rounding of positions, metres
    double least_depth = 0;                             ///< shallower points are dropped if others are left

    void begin(RegionKind kind, bool open, double rounding_of_positions);
    /// Adds a candidate of both bodies unless the draft has one of these features already.
    void add_shared(const ManifoldCandidate& candidate);

private:
    KeyNumbers shared_; ///< for pairs of features: the candidate
    std::vector<std::uint32_t> candidate_of_;
};

} // namespace oncollide
