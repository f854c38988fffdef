#pragma once
#include <cstdint>
#include <vector>

#include <optional>

#include <oncollide/narrowphase/mesh_leaf_test.hpp>
#include <oncollide/pipeline/forest.hpp>

namespace oncollide::tools {

/// The walk of two sphere-trees, one question at a time, driven as the pipeline's stage drives it.
/// Nothing is remembered from one question to the next but the trees.
class TreePair {
public:
    /// @param scene     two bodies with meshes; the second is moved
    /// @param settings  depth; with exact predicates these decide, and walks go to the depth of the exact level
    TreePair(Scene& scene, const Settings& settings);

    WalkResult walk(const Eigen::Isometry3d& b);
    /// Every two triangles that meet, each once, sorted. With exact predicates.
    void all_meeting(const Eigen::Isometry3d& b, std::vector<TriangleMeeting>& pairs);

    const Forest& forest() const { return forest_; }
    std::uint64_t cell_pairs() const { return walkers_[0].node_pairs() + walkers_[1].node_pairs(); }
    void reset_counters() { walkers_[0].reset_counters(), walkers_[1].reset_counters(); }

    const int depth;

private:
    WalkResult walk(const Eigen::Isometry3d& b, const LeafTest* test);

    Scene& scene_;
    Forest forest_;
    std::optional<MeshLeafTest> test_;
    Walker walkers_[2]; ///< the one at work, and the one that parked last
    std::vector<CellRequest> requests_;
};

} // namespace oncollide::tools
