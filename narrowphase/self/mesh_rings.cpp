#include <oncollide/narrowphase/self/mesh_rings.hpp>

#include <algorithm>

namespace oncollide {

MeshRings::MeshRings(const Mesh& mesh, std::span<const std::uint32_t> vertex)
    : begin_(mesh.vertices.size() + 2), beside_(6 * mesh.triangles.size())
{
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t) begin_[vertex[v] + 2] += 2;
    for (std::size_t v = 2; v < begin_.size(); ++v) begin_[v] += begin_[v - 1];
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t j = 1; j < 3; ++j) beside_[begin_[vertex[t[k]] + 1]++] = vertex[t[(k + j) % 3]];
}

bool MeshRings::Search::connects(std::span<const std::uint32_t> from, std::span<const std::uint32_t> to,
                                 std::uint32_t edges)
{
    const auto found = [&](std::uint32_t v) { return std::ranges::find(to, v) != to.end(); };
    reached_.assign(from.begin(), from.end());
    if (std::ranges::any_of(reached_, found)) return true;
    for (std::size_t begin = 0; edges > 0; --edges) {
        const std::size_t end = reached_.size();
        if (begin == end) break;
        for (; begin < end; ++begin)
            for (std::uint32_t i = rings_.begin_[reached_[begin]]; i < rings_.begin_[reached_[begin] + 1]; ++i) {
                const std::uint32_t v = rings_.beside_[i];
                if (found(v)) return true;
                if (std::ranges::find(reached_, v) == reached_.end()) reached_.push_back(v);
            }
    }
    return false;
}

} // namespace oncollide
