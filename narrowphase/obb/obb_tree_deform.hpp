#pragma once
// Private to the files of ObbTree.
#include <array>
#include <cstdint>

#include <oncollide/narrowphase/obb/fits/mesh_clusters.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>

namespace oncollide {

/// Keeps the tree of a mesh whose vertices move. A node's boxes are of the version in which they were fitted; they are
/// fitted anew when a traversal opens the node and some of their vertices have moved since. Boxes of few triangles are
/// fitted to them, others to the clusters of their triangles. Traversals may call make_current() concurrently.
class ObbTree::Deformation {
public:
    /// The version of boxes that fit nothing. New nodes have it: they are fitted when they are opened, like others, so
    /// that their boxes do not depend on the traversal that made them grow.
    static constexpr std::uint32_t never = ~0u;

    explicit Deformation(ObbTree& tree) : tree_(tree) {}

    void move(std::uint32_t first, std::uint32_t count, double radius2);
    void make_current(Node index);
    bool fits(Node index) const; ///< true if the node's boxes are as if they had been fitted now
    std::uint64_t boxes_refitted() const { return refitted_; }
    std::size_t bytes() const { return clusters_.bytes(); }

private:
    /// The triangles of a node's boxes, by position.
    struct Range {
        std::uint32_t begin, count = 0;
        std::array<std::uint32_t, most_lanes> counts{}; ///< by box
    };
    static constexpr std::uint32_t most_to_triangles = 512; ///< nodes of more triangles are fitted to clusters
    bool is_current(Node index) const { return tree_.node(index).fitted == version_; }
    Range range_of(Node index) const;
    bool moved(Node index, const Range& range) const;
    void fit_to_triangles(BoxNode& node, const Range& range) const;
    void fit_to_clusters(BoxNode& node, const Range& range) const;
    void bring_up_clusters();
    void add_clusters(Node index);
    bool is_scattered() const;
    void divide_anew();

    ObbTree& tree_;
    MeshClusters clusters_; ///< empty for few triangles, and until a node of many is opened
    std::uint32_t version_ = 0;
    std::uint32_t all_moved_at_ = 0; ///< the last version in which all boxes count as moved
    bool clusters_late_ = true;      ///< their AABBs are of an earlier version
    double scatter_ = 0;             ///< area of the clusters' AABBs, as a multiple of the area of the mesh's AABB
    double scatter_when_divided_ = 0;
    bool divided_anew_ = false;
    std::uint64_t refitted_ = 0; ///< boxes
};

} // namespace oncollide
