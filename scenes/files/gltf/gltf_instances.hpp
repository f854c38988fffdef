#pragma once
#include <optional>

#include <Eigen/Geometry>

#include <oncollide/scenes/files/gltf/gltf_accessor.hpp>

namespace oncollide {

/// The poses at which a node shows its mesh, relative to the node: one, unless it uses EXT_mesh_gpu_instancing. Private
/// to scenes.
class GltfInstances {
public:
    /// Throws Error{bad_data} naming the place.
    GltfInstances(const GltfDocument& document, GltfBuffers& buffers, const Node& node);

    std::size_t size() const { return size_; }
    /// The instances that the file holds one by one. A sparse accessor makes copies of one that take no bytes.
    std::size_t written() const { return written_; }
    Eigen::Affine3d pose(std::size_t i) const;

private:
    std::size_t size_ = 1, written_ = 1;
    std::optional<GltfAccessor> translation_, rotation_, scale_;
};

} // namespace oncollide
