#include <oncollide/scenes/model/vertex_mover.hpp>

#include <algorithm>
#include <cstring>

#include <oncollide/base/error.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/scenes/model/mesh_topology.hpp>
#include <oncollide/scenes/model/vertex_kernel.hpp>

namespace oncollide {

namespace {

const VertexKernel& vertex_kernel()
{
    static const VertexKernel kernel = ONCOLLIDE_CHOOSE_TO_AVX2(vertex_kernel);
    return kernel;
}

using Vertices = std::span<const Eigen::Vector3d>;
static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));

VertexExtent extent_of(Vertices vertices, Vertices before)
{
    VertexExtent extent;
    vertex_kernel().extent(vertices.data()->data(), before.data()->data(), vertices.size(), extent);
    return extent;
}
Aabb bounds_of(const VertexExtent& extent)
{
    return {Eigen::Vector3d(extent.low), Eigen::Vector3d(extent.high)};
}
bool is_allowed(const VertexExtent& extent)
{
    return extent.finite && std::ranges::all_of(extent.low, [](double x) { return x >= -largest_coordinate; }) &&
           std::ranges::all_of(extent.high, [](double x) { return x <= largest_coordinate; });
}

} // namespace

VertexMover::VertexMover(const Mesh& mesh)
{
    const std::vector<bool> used = used_vertices(mesh);
    for (std::uint32_t v = 0; v < used.size(); ++v)
        if (!used[v]) unused_.push_back(v);
}

/// Calls visit(vertices) for runs of vertices that triangles use.
void VertexMover::each_used(const Mesh& mesh, auto visit) const
{
    const Vertices vertices = mesh.vertices;
    std::size_t begin = 0;
    const auto visit_until = [&](std::size_t end) {
        if (begin < end) visit(vertices.subspan(begin, end - begin));
        begin = end + 1;
    };
    for (const std::uint32_t v : unused_) visit_until(v);
    visit_until(vertices.size());
}

VertexMove VertexMover::move(const std::string& name, Mesh& mesh, std::size_t first, Vertices positions) const
{
    ONCOLLIDE_ASSERT(first + positions.size() <= mesh.vertices.size());
    if (positions.empty()) return {};
    const VertexExtent extent = extent_of(positions, Vertices(mesh.vertices).subspan(first, positions.size()));
    if (!is_allowed(extent)) check_vertices(name, positions, first);
    VertexMove moved{.distance = Eigen::Vector3d(extent.moved).stableNorm() * (1 + 0x1p-50)};
    if (moved.distance == 0) return {};
    std::memmove(static_cast<void*>(&mesh.vertices[first]), positions.data(), positions.size_bytes());
    mesh.zero_area = mesh.triangles.size();
    if (positions.size() == mesh.vertices.size() && unused_.empty()) {
        mesh.bounds = bounds_of(extent);
    } else {
        Aabb bounds;
        each_used(mesh, [&](Vertices vertices) { bounds.add(bounds_of(extent_of(vertices, vertices))); });
        mesh.bounds = bounds;
    }
    const Eigen::Vector3d centre = mesh.bounds.centre();
    const double middle[3] = {centre.x(), centre.y(), centre.z()};
    each_used(mesh, [&](Vertices vertices) {
        moved.radius2 =
            std::max(moved.radius2, vertex_kernel().radius2(vertices.data()->data(), vertices.size(), middle));
    });
    return moved;
}

} // namespace oncollide
