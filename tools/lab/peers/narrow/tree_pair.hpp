#pragma once
#include <cstdint>

#include <oncollide/pipeline/refine/sphere_refiner.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

/// Traverses two sphere-trees, one query at a time, with the refiner of the pipeline's stage. Only the trees are kept
/// from one query to the next.
class TreePair {
public:
    /// @param scene  two bodies with meshes; the second is moved
    TreePair(const Scene& scene, const Settings& settings);

    Finding walk(const Eigen::Isometry3d& b);

    const ModelStore& models() const { return models_; }
    std::uint64_t cell_pairs() const { return context_.trees.node_pairs; }

    const int depth;

private:
    Settings settings_;
    ModelStore models_;
    Model &a_, &b_;
    Eigen::Isometry3d pose_a_;
    SphereRefiner refiner_;
    RefineContext context_;
};

} // namespace oncollide::tools
