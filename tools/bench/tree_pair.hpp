#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/pipeline/forest.hpp>

namespace oncollide::tools {

/// The walk of two sphere-trees, one question at a time, driven as the pipeline's stage drives it.
/// Nothing is remembered from one question to the next but the trees.
class TreePair {
public:
    /// @param scene     two bodies with meshes; the second is moved
    TreePair(Scene& scene, const Settings& settings);

    WalkResult walk(const Eigen::Isometry3d& b);

    const Forest& forest() const { return forest_; }
    std::uint64_t cell_pairs() const { return walkers_[0].node_pairs() + walkers_[1].node_pairs(); }
    void reset_counters() { walkers_[0].reset_counters(), walkers_[1].reset_counters(); }

    const int depth;

private:
    Scene& scene_;
    Forest forest_;
    Walker walkers_[2]; ///< the one at work, and the one that parked last
    std::vector<CellRequest> requests_;
};

} // namespace oncollide::tools
