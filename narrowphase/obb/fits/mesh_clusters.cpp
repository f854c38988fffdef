#include <oncollide/narrowphase/obb/fits/mesh_clusters.hpp>

#include <algorithm>

#include <oncollide/base/error.hpp>

namespace oncollide {

double area_of(const Aabb& box)
{
    const Eigen::Vector3d d = box.max - box.min;
    return 2 * (d.x() * d.y() + d.y() * d.z() + d.z() * d.x());
}

void MeshClusters::clear()
{
    clusters_.clear(), vertices_.clear();
    area_ = 0;
}

void MeshClusters::add(const Mesh& mesh, std::uint32_t begin, std::span<const std::uint32_t> triangles)
{
    const std::size_t first = vertices_.size();
    for (const std::uint32_t t : triangles)
        vertices_.insert(vertices_.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
    const auto from = vertices_.begin() + static_cast<std::ptrdiff_t>(first);
    std::sort(from, vertices_.end());
    vertices_.erase(std::unique(from, vertices_.end()), vertices_.end());
    clusters_.push_back({.box = {},
                         .begin = begin,
                         .first = static_cast<std::uint32_t>(first),
                         .lowest = vertices_[first],
                         .highest = vertices_.back(),
                         .moved_at = 0});
}

void MeshClusters::end()
{
    clusters_.shrink_to_fit(), vertices_.shrink_to_fit();
}

void MeshClusters::move(std::uint32_t first, std::uint32_t count, std::uint32_t version)
{
    for (Cluster& cluster : clusters_)
        if (cluster.highest >= first && cluster.lowest < std::uint64_t{first} + count)
            cluster.moved_at = version, cluster.late = true;
}

void MeshClusters::update(const Mesh& mesh)
{
    area_ = 0;
    for (std::size_t i = 0; i < clusters_.size(); ++i) {
        Cluster& cluster = clusters_[i];
        if (cluster.late) {
            const std::size_t end = i + 1 < clusters_.size() ? clusters_[i + 1].first : vertices_.size();
            Aabb box; // a local, which the compiler can keep in registers
            for (std::size_t k = cluster.first; k < end; ++k) box.add(mesh.vertices[vertices_[k]]);
            cluster.box = box, cluster.late = false;
        }
        area_ += area_of(cluster.box);
    }
}

std::size_t MeshClusters::cluster_at(std::uint32_t position) const
{
    const auto after = std::ranges::upper_bound(clusters_, position, {}, &Cluster::begin);
    ONCOLLIDE_ASSERT(after != clusters_.begin());
    return static_cast<std::size_t>(after - clusters_.begin()) - 1;
}

bool MeshClusters::moved_since(std::uint32_t version, std::uint32_t begin, std::uint32_t count) const
{
    for (std::size_t i = cluster_at(begin); i < clusters_.size() && clusters_[i].begin < begin + count; ++i)
        if (clusters_[i].moved_at > version) return true;
    return false;
}

Aabb MeshClusters::bounds(std::uint32_t begin, std::uint32_t count) const
{
    Aabb box;
    for (std::size_t i = cluster_at(begin); i < clusters_.size() && clusters_[i].begin < begin + count; ++i)
        box.add(clusters_[i].box);
    return box;
}

std::size_t MeshClusters::bytes() const
{
    return clusters_.capacity() * sizeof(Cluster) + vertices_.capacity() * sizeof(std::uint32_t);
}

} // namespace oncollide
