#include <oncollide/scenes/files/gltf/gltf_nodes.hpp>

#include <utility>

#include <fmt/format.h>

namespace oncollide {

Eigen::Affine3d pose_of(const Node& node)
{
    Eigen::Affine3d pose = Eigen::Affine3d::Identity();
    if (node.has("matrix")) {
        const Node matrix = node["matrix"];
        matrix.numbers(16, pose.matrix().data()); // column-major, as in Eigen
        const Eigen::RowVector4d last = pose.matrix().row(3);
        if (!((last - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() < 1e-6))
            matrix.fail("its last row must be 0, 0, 0, 1");
        pose.makeAffine();
        return pose;
    }
    if (node.has("translation")) pose.translate(node["translation"].vector3());
    if (node.has("rotation")) {
        Eigen::Quaterniond rotation;
        node["rotation"].numbers(4, rotation.coeffs().data()); // x, y, z, w, as in Eigen
        if (!(rotation.norm() > 1e-6)) node["rotation"].fail("the quaternion has no direction");
        pose.rotate(rotation.normalized());
    }
    if (node.has("scale")) pose.scale(node["scale"].vector3());
    return pose;
}

NodeTree node_tree(const GltfDocument& document)
{
    const std::vector<Node>& nodes = document.all(GltfDocument::nodes);
    NodeTree tree{std::vector<std::uint32_t>(nodes.size(), no_node), {}, std::vector<bool>(nodes.size(), false)};
    std::vector<std::vector<std::uint32_t>> children(nodes.size());
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
        if (!nodes[i].has("children")) continue;
        for (const Node& number : list_of(nodes[i]["children"])) {
            const auto child = static_cast<std::uint32_t>(document.index(GltfDocument::nodes, number));
            if (std::exchange(tree.parents[child], i) != no_node)
                number.fail(fmt::format("nodes[{}] has two parents; nodes must form a tree", child));
            children[i].push_back(child);
        }
    }
    for (std::uint32_t i = 0; i < nodes.size(); ++i)
        if (tree.parents[i] == no_node) tree.order.push_back(i);
    const std::size_t roots = tree.order.size();
    for (std::size_t at = 0; at < tree.order.size(); ++at)
        for (const std::uint32_t child : children[tree.order[at]]) tree.order.push_back(child);
    if (tree.order.size() < nodes.size())
        document.source().fail("nodes are their own ancestors; nodes must form a tree");

    if (document.all(GltfDocument::scenes).empty()) {
        tree.shown.assign(nodes.size(), true);
        return tree;
    }
    const Node root = document.root();
    const Node& scene = root.has("scene") ? document.at(GltfDocument::scenes, root["scene"])
                                          : document.all(GltfDocument::scenes).front();
    if (scene.has("nodes"))
        for (const Node& number : list_of(scene["nodes"])) {
            const std::size_t i = document.index(GltfDocument::nodes, number);
            if (tree.parents[i] != no_node || tree.shown[i])
                number.fail(fmt::format("nodes[{}] has two parents, the scene and {}", i,
                                        tree.shown[i] ? "the scene" : fmt::format("nodes[{}]", tree.parents[i])));
            tree.shown[i] = true;
        }
    for (std::size_t at = roots; at < tree.order.size(); ++at)
        tree.shown[tree.order[at]] = tree.shown[tree.parents[tree.order[at]]];
    return tree;
}

} // namespace oncollide
