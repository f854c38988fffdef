#include <oncollide/narrowphase/shapes/hull_faces.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

namespace oncollide {

namespace {

using Eigen::Vector3d;
using HullEdge = std::pair<std::uint32_t, std::uint32_t>;

constexpr double same_plane = 0x1p-30; ///< share of the hull's size

} // namespace

HullFaces::HullFaces(const Mesh& surface)
{
    const auto& points = surface.vertices;
    const auto& triangles = surface.triangles;
    const auto count = static_cast<std::uint32_t>(triangles.size());
    std::map<HullEdge, std::uint32_t> triangle_of; // by directed edge
    std::vector<Vector3d> area(count);
    double size = 0;
    for (std::uint32_t t = 0; t < count; ++t) {
        const auto& [u, v, w] = triangles[t];
        triangle_of[{u, v}] = triangle_of[{v, w}] = triangle_of[{w, u}] = t;
        area[t] = (points[v] - points[u]).cross(points[w] - points[u]);
        size = std::max(size, std::max((points[v] - points[u]).norm(), (points[w] - points[u]).norm()));
    }
    // Large triangles first: they define the planes, and slivers join them.
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::uint32_t t) { return area[t].squaredNorm(); });
    std::vector<std::uint8_t> taken(count, 0);
    std::vector<std::uint32_t> members;
    for (const std::uint32_t seed : order) {
        if (taken[seed]) continue;
        const Vector3d normal = area[seed].normalized(), from = points[triangles[seed][0]];
        const auto in_plane = [&](std::uint32_t t) {
            return normal.dot(area[t]) >= 0 && std::ranges::all_of(triangles[t], [&](std::uint32_t v) {
                       return std::abs(normal.dot(points[v] - from)) <= same_plane * size;
                   });
        };
        members.assign(1, seed), taken[seed] = 1;
        std::map<std::uint32_t, std::uint32_t> next; // along the border
        for (std::size_t i = 0; i < members.size(); ++i)
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t u = triangles[members[i]][k], v = triangles[members[i]][(k + 1) % 3];
                const std::uint32_t across = triangle_of.at({v, u});
                if (!taken[across] && in_plane(across)) members.push_back(across), taken[across] = 1;
            }
        std::ranges::sort(members);
        const auto is_member = [&](std::uint32_t t) { return std::ranges::binary_search(members, t); };
        for (const std::uint32_t t : members)
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t u = triangles[t][k], v = triangles[t][(k + 1) % 3];
                if (!is_member(triangle_of.at({v, u}))) next[u] = v;
            }
        Face face{normal, 0, 1, static_cast<std::uint32_t>(corners_.size()), 0, members.front()};
        const std::uint32_t start = next.begin()->first;
        for (std::uint32_t v = start; face.count == 0 || (v != start && face.count < next.size()); v = next.at(v)) {
            corners_.push_back(v), ++face.count;
            face.off = std::max(face.off, std::abs(normal.dot(points[v] - points[start])));
        }
        for (std::uint32_t k = 0; k < face.count; ++k) {
            const auto corner = [&](std::uint32_t i) { return points[corners_[face.first + i % face.count]]; };
            const Vector3d to = (corner(k + 1) - corner(k)).normalized(),
                           back = (corner(k + face.count - 1) - corner(k)).normalized();
            face.sharp = std::max(face.sharp, 2 / (to - back).norm());
        }
        faces_.push_back(face);
    }
    std::vector<std::vector<std::uint32_t>> around(points.size());
    for (std::uint32_t f = 0; f < faces_.size(); ++f)
        for (const std::uint32_t v : corners(faces_[f])) around[v].push_back(f);
    first_.assign(1, 0);
    for (const auto& own : around) {
        around_.insert(around_.end(), own.begin(), own.end());
        first_.push_back(static_cast<std::uint32_t>(around_.size()));
    }
}

std::size_t HullFaces::bytes() const
{
    return faces_.capacity() * sizeof(Face) + (corners_.capacity() + around_.capacity() + first_.capacity()) * 4;
}

} // namespace oncollide
