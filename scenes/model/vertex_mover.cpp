#include <oncollide/scenes/model/vertex_mover.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

/// Bounds of some vertices, and how far they are from others. Two vertices at a time, which compiles to vector
/// instructions.
struct Extent {
    using Two = Eigen::Array<double, 6, 1>;
    using Load = Eigen::Map<const Two, Eigen::Unaligned>;
    Two low = Two::Constant(std::numeric_limits<double>::infinity()), high = -low;
    Two moved = Two::Zero(); ///< greatest magnitudes
    Two odd = Two::Zero();   ///< not a number if any coordinate is not finite

    void add(const Eigen::Vector3d* at, const Eigen::Vector3d* from)
    {
        const Load now(at->data()), before(from->data());
        low = low.min(now), high = high.max(now), moved = moved.max((now - before).abs()), odd += now * 0.0;
    }
    Aabb bounds() const
    {
        Aabb box;
        box.min = low.head<3>().min(low.tail<3>()), box.max = high.head<3>().max(high.tail<3>());
        return box;
    }
    double distance() const
    {
        const Eigen::Vector3d most = moved.head<3>().max(moved.tail<3>());
        return most.stableNorm() * (1 + 0x1p-50);
    }
};

Extent extent_of(std::span<const Eigen::Vector3d> vertices, std::span<const Eigen::Vector3d> from)
{
    Extent extent;
    std::size_t i = 0;
    for (; i + 2 <= vertices.size(); i += 2) extent.add(&vertices[i], &from[i]);
    if (i < vertices.size()) {
        const Eigen::Vector3d last[2] = {vertices[i], vertices[i]}, before[2] = {from[i], from[i]};
        extent.add(last, before);
    }
    return extent;
}

} // namespace

VertexMover::VertexMover(const Mesh& mesh)
{
    std::vector<bool> used(mesh.vertices.size());
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t) used[v] = true;
    for (std::uint32_t v = 0; v < used.size(); ++v)
        if (!used[v]) unused_.push_back(v);
}

/// Calls visit(vertices) for runs of vertices that triangles use.
void VertexMover::each_used(const Mesh& mesh, auto visit) const
{
    const std::span<const Eigen::Vector3d> vertices = mesh.vertices;
    std::size_t begin = 0;
    for (const std::uint32_t v : unused_) visit(vertices.subspan(begin, v - begin)), begin = v + std::size_t{1};
    visit(vertices.subspan(begin));
}

VertexMove VertexMover::move(const std::string& name, Mesh& mesh, std::size_t first,
                             std::span<const Eigen::Vector3d> positions) const
{
    ONCOLLIDE_ASSERT(first + positions.size() <= mesh.vertices.size());
    if (positions.empty()) return {};
    const Extent extent = extent_of(positions, std::span(mesh.vertices).subspan(first, positions.size()));
    if (!(extent.odd == 0).all() || !(extent.low >= -largest_coordinate).all() ||
        !(extent.high <= largest_coordinate).all())
        check_vertices(name, positions, first);
    VertexMove moved{.distance = extent.distance()};
    if (moved.distance == 0) return {};
    std::memmove(static_cast<void*>(&mesh.vertices[first]), positions.data(), positions.size_bytes());
    mesh.zero_area = mesh.triangles.size();
    if (positions.size() == mesh.vertices.size() && unused_.empty()) {
        mesh.bounds = extent.bounds();
    } else {
        Aabb bounds;
        each_used(mesh, [&](auto vertices) { bounds.add(extent_of(vertices, vertices).bounds()); });
        mesh.bounds = bounds;
    }
    const Eigen::Vector3d centre = mesh.bounds.centre();
    each_used(mesh, [&](auto vertices) {
        for (const Eigen::Vector3d& v : vertices) moved.radius2 = std::max(moved.radius2, (v - centre).squaredNorm());
    });
    return moved;
}

} // namespace oncollide
