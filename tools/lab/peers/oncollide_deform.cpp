// oncollide on meshes that deform.
#include "peers/peers.hpp"

#include <optional>

#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>
#include <oncollide/scenes/model/vertex_mover.hpp>

namespace oncollide::tools {
namespace {

/// Moves vertices as Models::set_vertices() does, and finds all pairs that meet, as for contacts.
class OurDeformPeer final : public DeformPeer {
public:
    OurDeformPeer(const Mesh& a, const Mesh& b) : sides_{Side(a), Side(b)} {}

    void set_vertices(int which, std::span<const Eigen::Vector3d> positions) override
    {
        Side& side = sides_[which];
        const VertexMove moved = side.mover.move("mesh", side.mesh, 0, positions);
        if (moved.distance > 0) side.tree.deform(0, static_cast<std::uint32_t>(positions.size()), moved.radius2);
    }
    void all_pairs(std::vector<TrianglePair>& pairs) override
    {
        walk_.all_meeting(sides_[0].tree, sides_[1].tree,
                          RelativePose(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()), pairs);
    }
    std::uint64_t boxes_refitted() const override { return sides_[0].tree.boxes_refitted(); }
    std::uint64_t boxes() override { return boxes_below(sides_[0].tree, ObbTree::root); }
    std::size_t bytes() const override
    {
        const Mesh& mesh = sides_[0].mesh;
        return mesh.vertices.size() * sizeof(mesh.vertices[0]) + mesh.triangles.size() * sizeof(mesh.triangles[0]) +
               sides_[0].tree.bytes();
    }

private:
    struct Side {
        Mesh mesh;
        VertexMover mover;
        ObbTree tree;
        explicit Side(const Mesh& m) : mesh(m), mover(mesh), tree(mesh) {}
        Side(const Side&) = delete;
    };
    static std::uint64_t boxes_below(ObbTree& tree, ObbTree::Node node)
    {
        std::uint64_t boxes = tree.node(node).lanes;
        for (unsigned k = 0; k < tree.node(node).lanes; ++k)
            if (!(tree.node(node).leaves >> k & 1)) boxes += boxes_below(tree, tree.child(node, k));
        return boxes;
    }

    Side sides_[2];
    Traversal walk_;
};

} // namespace

void add_deform(Contenders& all)
{
    all.deform.all.push_back({.name = "oncollide",
                              .what = "VertexMover and ObbTree::deform(), as Models::set_vertices(); exact predicates",
                              .group = Group::oncollide,
                              .make = maker<OurDeformPeer>()});
}

} // namespace oncollide::tools
