#include <oncollide/scenes/files/gltf/gltf_instances.hpp>

#include <algorithm>

#include <fmt/format.h>

namespace oncollide {

GltfInstances::GltfInstances(const GltfDocument& document, GltfBuffers& buffers, const Node& node)
{
    constexpr const char* name = "EXT_mesh_gpu_instancing";
    if (!node.has("extensions") || !node["extensions"].has(name)) return;
    const Node attributes = node["extensions"][name]["attributes"];
    bool is_first = true;
    const auto read = [&](const char* key, GltfAccessor::Vectors kind, std::optional<GltfAccessor>& to) {
        if (!attributes.has(key)) return;
        to = GltfAccessor::of_vectors(document, buffers, attributes[key], kind);
        if (!is_first && to->size() != size_)
            attributes[key].fail(fmt::format("has {} instances, another attribute {}", to->size(), size_));
        size_ = to->size(), written_ = is_first ? to->written() : std::max(written_, to->written());
        is_first = false;
    };
    read("TRANSLATION", GltfAccessor::Vectors::points, translation_);
    read("ROTATION", GltfAccessor::Vectors::quaternions, rotation_);
    read("SCALE", GltfAccessor::Vectors::points, scale_);
}

Eigen::Affine3d GltfInstances::pose(std::size_t i) const
{
    Eigen::Affine3d pose = Eigen::Affine3d::Identity();
    if (translation_) pose.translate(translation_->position(i));
    if (rotation_) pose.rotate(rotation_->quaternion(i));
    if (scale_) pose.scale(scale_->position(i));
    return pose;
}

} // namespace oncollide
