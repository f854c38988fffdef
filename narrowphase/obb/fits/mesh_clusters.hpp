#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// The surface area of a box.
double area_of(const Aabb& box);

/// The triangles of an OBB tree in clusters of consecutive positions, with AABBs that follow the vertices: the boxes of
/// many triangles come from these. Versions count the changes of the mesh.
class MeshClusters {
public:
    static constexpr std::uint32_t most = 256; ///< triangles of a cluster

    bool empty() const { return clusters_.empty(); }
    std::size_t size() const { return clusters_.size(); }
    void clear();
    /// Adds the triangles at positions [begin, begin + triangles.size()), which follow the last cluster.
    /// @param triangles  their numbers
    void add(const Mesh& mesh, std::uint32_t begin, std::span<const std::uint32_t> triangles);
    /// Call it after the last add().
    void end();

    /// Vertices [first, first + count) moved and made the mesh's version `version`. Cost: O(clusters).
    void move(std::uint32_t first, std::uint32_t count, std::uint32_t version);
    /// Brings the AABBs up to date. Cost: 3 ns per vertex of the clusters that moved.
    void update(const Mesh& mesh);
    /// True if a cluster with a triangle at positions [begin, begin + count) moved after `version`.
    bool moved_since(std::uint32_t version, std::uint32_t begin, std::uint32_t count) const;
    /// The bounds of these clusters, as of the last update().
    Aabb bounds(std::uint32_t begin, std::uint32_t count) const;
    /// The sum of the areas of the AABBs: divided by the area of the mesh's AABB, the number of clusters that a small
    /// box in it meets.
    double area() const { return area_; }
    std::size_t bytes() const;

private:
    struct Cluster {
        Aabb box;
        std::uint32_t begin;           ///< position of its first triangle
        std::uint32_t first;           ///< of its vertices in vertices_
        std::uint32_t lowest, highest; ///< of its vertices' numbers
        std::uint32_t moved_at;        ///< version in which a vertex with a number between these moved last
        bool late = true;              ///< the box is of an earlier version
    };
    std::size_t cluster_at(std::uint32_t position) const;

    std::vector<Cluster> clusters_;       ///< by position
    std::vector<std::uint32_t> vertices_; ///< cluster by cluster, each vertex of a cluster once, ascending
    double area_ = 0;
};

} // namespace oncollide
