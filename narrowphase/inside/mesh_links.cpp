#include <oncollide/narrowphase/inside/mesh_links.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/wide_vector.hpp>

namespace oncollide {

namespace {

/// The sign of the volume that a closed mesh encloses, exactly.
int volume_sign(const Mesh& mesh)
{
    double volume = 0, magnitude = 0;
    const Eigen::Vector3d middle = mesh.bounds.centre();
    for (const Triangle& t : mesh.triangles) {
        const Eigen::Vector3d a = mesh.vertices[t[0]] - middle, b = mesh.vertices[t[1]] - middle,
                              c = mesh.vertices[t[2]] - middle;
        volume += a.dot(b.cross(c)), magnitude += a.norm() * b.norm() * c.norm();
    }
    // Each product passes through less than 16 roundings, and the sum adds one per triangle.
    if (std::abs(volume) > 0x1p-53 * (16 + double(mesh.triangles.size())) * magnitude) return volume < 0 ? -1 : 1;
    std::vector<double> coordinates;
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t)
            coordinates.insert(coordinates.end(), {mesh.vertices[v].x(), mesh.vertices[v].y(), mesh.vertices[v].z()});
    const BinaryGrid grid = grid_of(coordinates);
    return with_limbs(grid, [&](auto limbs) {
        constexpr int n = decltype(limbs)::value;
        const Eigen::Vector3d& first = mesh.vertices[mesh.triangles[0][0]];
        const auto from_first = [&](std::uint32_t v) { return difference<n, 3>(grid, mesh.vertices[v], first); };
        WideInteger<3 * n + 1> sum;
        for (const auto& [a, b, c] : mesh.triangles)
            sum = sum + dot(cross<n>(from_first(a), from_first(b)), from_first(c)) * WideInteger<1>{{1}};
        return sum.sign();
    });
}

/// An edge sticks out unless the triangle behind it is in the plane or in front of it.
void find_ridges(const Mesh& mesh, MeshLinks& links)
{
    links.ridges.assign(mesh.triangles.size(), 0), links.tips.assign(mesh.vertices.size(), false);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto [a, b, c] = mesh.triangles[t];
        for (int k = 0; k < 3; ++k) {
            bool out = true;
            if (const std::uint32_t beyond = links.neighbours[t][k]; beyond != MeshLinks::none) {
                out = false;
                for (const std::uint32_t v : mesh.triangles[beyond]) {
                    const int side = orient3d(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c], mesh.vertices[v]);
                    out |= links.reversed ? side > 0 : side < 0;
                }
            }
            if (!out) continue;
            links.ridges[t] |= 1 << k;
            for (const int i : {k, (k + 1) % 3}) links.tips[links.vertex[mesh.triangles[t][i]]] = true;
        }
    }
}

} // namespace

MeshLinks links_of(const Mesh& mesh)
{
    MeshLinks links;
    const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t v) {
        const Eigen::Vector3d& p = mesh.vertices[v];
        return std::tuple(p.x(), p.y(), p.z(), v);
    };
    std::ranges::sort(order, {}, key);
    links.vertex.resize(count);
    for (std::uint32_t i = 0; i < count; ++i)
        links.vertex[order[i]] =
            i && mesh.vertices[order[i]] == mesh.vertices[order[i - 1]] ? links.vertex[order[i - 1]] : order[i];

    struct Side {
        std::uint32_t low, high, triangle;
        std::uint8_t corner;
        bool up;
    };
    std::vector<Side> sides;
    sides.reserve(3 * mesh.triangles.size());
    links.neighbours.assign(mesh.triangles.size(), {MeshLinks::none, MeshLinks::none, MeshLinks::none});
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto [a, b, c] = mesh.triangles[t];
        if (collinear(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c])) continue; // as in is_closed()
        for (std::uint8_t k = 0; k < 3; ++k) {
            const std::uint32_t u = links.vertex[mesh.triangles[t][k]],
                                v = links.vertex[mesh.triangles[t][(k + 1) % 3]];
            sides.push_back({std::min(u, v), std::max(u, v), t, k, u < v});
        }
    }
    std::ranges::sort(sides, {}, [](const Side& s) { return std::tuple(s.low, s.high, s.triangle, s.corner); });
    links.closed = !sides.empty();
    for (std::size_t i = 0; i < sides.size();) {
        std::size_t end = i + 1;
        while (end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high) ++end;
        const auto same = std::span(sides).subspan(i, end - i);
        if (2 * std::ranges::count_if(same, &Side::up) != std::ptrdiff_t(same.size()))
            links.closed = false;
        else if (same.size() == 2) {
            links.neighbours[sides[i].triangle][sides[i].corner] = sides[i + 1].triangle;
            links.neighbours[sides[i + 1].triangle][sides[i + 1].corner] = sides[i].triangle;
        }
        i = end;
    }
    links.reversed = links.closed && volume_sign(mesh) < 0;
    find_ridges(mesh, links);
    return links;
}

} // namespace oncollide
