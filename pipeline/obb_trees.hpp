#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include <oncollide/narrowphase/boxes/obb_tree.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// The trees of oriented boxes of a scene's meshes. Made when a pair first needs them, dropped when none has for long.
class ObbTrees {
public:
    /// Keeps a reference to the geometries.
    explicit ObbTrees(const Scene& scene) : scene_(scene), trees_(scene.geometries.size()) {}

    /// What trees may come to hold, all grown.
    struct Room {
        std::uint64_t nodes = 0;
        std::size_t bytes = 0;
    };
    /// Sees to it that a mesh has its tree, and marks it as used. False when it is no mesh, or when its tree, all
    /// grown, might not fit into `room`. Not while walks are under way.
    bool admit(GeometryId geometry, std::uint32_t frame, const Room& room);
    ObbTree& operator[](GeometryId geometry) { return *trees_[index(geometry)].tree; }

    /// Drops trees that were last used `age` frames ago or before. Returns how many nodes went.
    std::uint64_t drop(std::uint32_t frame, std::uint32_t age);

    std::uint64_t nodes() const;
    std::size_t bytes() const;
    const Room& reserved() const { return reserved_; } ///< what the trees there are, all grown, may come to hold

private:
    struct Tree {
        std::unique_ptr<ObbTree> tree;
        std::uint32_t used = 0; ///< frame
    };
    static Room most(const Mesh& mesh) { return {ObbTree::most_nodes(mesh), ObbTree::most_bytes(mesh)}; }

    const Scene& scene_;
    std::vector<Tree> trees_;         ///< by geometry
    std::vector<std::uint32_t> live_; ///< geometries that have a tree
    Room reserved_;
};

} // namespace oncollide
