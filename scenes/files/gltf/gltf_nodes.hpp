#pragma once
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/files/assembly/raw_assembly.hpp>
#include <oncollide/scenes/files/gltf/gltf_document.hpp>

namespace oncollide {

/// The nodes of a glTF file in an order from the roots down. Private to scenes.
struct NodeTree {
    std::vector<std::uint32_t> parents, order;
    std::vector<bool> shown; ///< visible in the scene
};

/// Throws Error{bad_data} unless nodes form trees.
NodeTree node_tree(const GltfDocument& document);

/// Pose of a node in its parent's frame.
Eigen::Affine3d pose_of(const Node& node);

} // namespace oncollide
