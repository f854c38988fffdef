#include <oncollide/robots/cover.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace oncollide {

CoverSphere enclosing_sphere(std::span<const Eigen::Vector3d> points)
{
    Aabb box;
    for (const Eigen::Vector3d& p : points) box.add(p);
    Eigen::Vector3d centre = box.centre();
    const auto farthest = [&](const Eigen::Vector3d& c) {
        return *std::ranges::max_element(points, {}, [&](const Eigen::Vector3d& p) { return (p - c).squaredNorm(); });
    };
    // Badoiu and Clarkson, "Smaller core-sets for balls", 2003: steps to the farthest point, each shorter.
    Eigen::Vector3d best = centre, far = farthest(centre);
    double least = (far - centre).squaredNorm();
    for (int i = 2; i < 60 && least > 0; ++i) {
        centre += (far - centre) / i;
        far = farthest(centre);
        if (const double square = (far - centre).squaredNorm(); square < least) least = square, best = centre;
    }
    return {best, std::sqrt(least) * (1 + 1e-12) + 1e-15 * best.cwiseAbs().maxCoeff()};
}

CoverSphere around_spheres(std::span<const CoverSphere> spheres)
{
    Aabb box;
    for (const CoverSphere& sphere : spheres) box.add(sphere.centre);
    CoverSphere whole{box.centre(), 0};
    for (const CoverSphere& sphere : spheres)
        whole.radius = std::max(whole.radius, (sphere.centre - whole.centre).norm() + sphere.radius);
    return whole;
}

std::vector<CoverSphere> cover_triangles(const Mesh& mesh, std::size_t count)
{
    const auto middle = [&](std::uint32_t t) {
        const Triangle& corners = mesh.triangles[t];
        return Eigen::Vector3d(mesh.vertices[corners[0]] + mesh.vertices[corners[1]] + mesh.vertices[corners[2]]);
    };
    std::vector<std::uint32_t> order(mesh.triangles.size());
    std::iota(order.begin(), order.end(), 0u);
    using Part = std::span<std::uint32_t>;
    std::vector<Eigen::Vector3d> corners;
    const auto sphere_of = [&](Part part) {
        corners.clear();
        for (const std::uint32_t t : part)
            for (const std::uint32_t v : mesh.triangles[t]) corners.push_back(mesh.vertices[v]);
        return enclosing_sphere(corners);
    };
    std::vector<Part> parts{order};
    std::vector<CoverSphere> spheres{sphere_of(order)};
    while (spheres.size() < count) { // halves the largest part
        const auto largest =
            static_cast<std::size_t>(std::ranges::max_element(spheres, {}, &CoverSphere::radius) - spheres.begin());
        const Part part = parts[largest];
        if (part.size() < 2) break;
        Aabb box;
        for (const std::uint32_t t : part) box.add(middle(t));
        Eigen::Index axis = 0;
        (box.max - box.min).maxCoeff(&axis);
        std::ranges::nth_element(part, part.begin() + static_cast<std::ptrdiff_t>(part.size() / 2), {},
                                 [&](std::uint32_t t) { return middle(t)[axis]; });
        parts[largest] = part.first(part.size() / 2), parts.push_back(part.subspan(part.size() / 2));
        spheres[largest] = sphere_of(parts[largest]), spheres.push_back(sphere_of(parts.back()));
    }
    return spheres;
}

std::vector<CoverSphere> cover_box(const Aabb& box, std::size_t count)
{
    const Eigen::Vector3d size = box.max - box.min;
    Eigen::Index axis = 0;
    const double longest = size.maxCoeff(&axis);
    Eigen::Vector3d across = size;
    across[axis] = 0;
    // Slices are about as long as the box is wide; more slices would not make the spheres smaller.
    const double wanted = across.norm() > 0 ? std::ceil(longest / across.norm()) : double(count);
    const std::size_t slices =
        std::max<std::size_t>(1, std::min(count, static_cast<std::size_t>(std::min(wanted, 1e3))));
    std::vector<CoverSphere> spheres;
    for (std::size_t i = 0; i < slices; ++i) {
        Eigen::Vector3d centre = box.centre();
        centre[axis] = box.min[axis] + longest * (double(i) + 0.5) / double(slices);
        const double radius = 0.5 * std::hypot(across.norm(), longest / double(slices));
        spheres.push_back({centre, radius * (1 + 1e-12) + 1e-15 * centre.cwiseAbs().maxCoeff()});
    }
    return spheres;
}

} // namespace oncollide
