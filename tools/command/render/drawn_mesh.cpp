#include "render/drawn_mesh.hpp"

#include <algorithm>

namespace oncollide::tools {
namespace {

Mesh square_below(const Scene& scene)
{
    double far = 1;
    for (std::size_t body = 0; body < scene.size(); ++body)
        far = std::max(far, scene.start_pose(body).translation().lpNorm<Eigen::Infinity>());
    return make_mesh("half-space", {{-far, -far, 0}, {far, -far, 0}, {far, far, 0}, {-far, far, 0}},
                     {{0, 1, 2}, {0, 2, 3}});
}

} // namespace

Mesh mesh_of_boxes(const std::string& name, const std::vector<Aabb>& boxes)
{
    // Corner k is on the high side of axis a when bit a is set; two triangles per face.
    constexpr std::uint32_t faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                            {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> triangles;
    vertices.reserve(8 * boxes.size()), triangles.reserve(12 * boxes.size());
    for (const Aabb& box : boxes) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        for (unsigned k = 0; k < 8; ++k)
            vertices.emplace_back((k & 1 ? box.max : box.min).x(), (k & 2 ? box.max : box.min).y(),
                                  (k & 4 ? box.max : box.min).z());
        for (const auto& face : faces) triangles.push_back({first + face[0], first + face[1], first + face[2]});
    }
    return make_mesh(name, std::move(vertices), std::move(triangles));
}

Mesh drawn_mesh(const Shape& shape, const Scene& scene)
{
    return std::holds_alternative<HalfSpace>(shape) ? square_below(scene) : bounding_mesh_of(shape).mesh;
}

Mesh part_of(const Mesh& mesh, std::span<const std::uint32_t> triangles)
{
    if (triangles.empty()) return {};
    constexpr std::uint32_t none = ~0u;
    std::vector<std::uint32_t> number(mesh.vertices.size(), none); // of a vertex in the part
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> part;
    for (const std::uint32_t t : triangles) {
        Triangle& made = part.emplace_back(mesh.triangles[t]);
        for (std::uint32_t& v : made) {
            if (number[v] == none)
                number[v] = static_cast<std::uint32_t>(vertices.size()), vertices.push_back(mesh.vertices[v]);
            v = number[v];
        }
    }
    return make_mesh("part", std::move(vertices), std::move(part));
}

} // namespace oncollide::tools
