#include "truth/near_bodies.hpp"

#include <algorithm>
#include <numeric>

#include "truth/convex_truth.hpp"

namespace oncollide::tools {
namespace {

/// The body's world AABB, grown by more than rounding, and poses that are rigid only to 1e-6, can move a point.
Aabb world_box(const Scene& scene, std::uint32_t body, double clearance)
{
    const Geometry& geometry = scene.geometries[index(scene.geometry[body])];
    const Eigen::Isometry3d& pose = scene.poses[body];
    Aabb box;
    double largest = 0;
    const auto add = [&](const Eigen::Vector3d& p) {
        box.add(pose * p), largest = std::max(largest, p.cwiseAbs().maxCoeff());
    };
    if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) {
        for (const Eigen::Vector3d& v : mesh->vertices) add(v);
    } else {
        for (const Eigen::Vector3d& corner : corners_of(bounds_of(geometry))) add(corner);
    }
    const double slack =
        clearance / 2 + 0x1p-16 * (largest + clearance) + 0x1p-40 * pose.translation().cwiseAbs().maxCoeff();
    box.min.array() -= slack, box.max.array() += slack;
    return box;
}

} // namespace

std::vector<BodyPair> near_bodies(const Scene& scene, double clearance)
{
    std::vector<Aabb> boxes;
    for (std::uint32_t body = 0; body < scene.size(); ++body) boxes.push_back(world_box(scene, body, clearance));
    const BodyColumns columns{boxes, scene.layers, scene.masks};
    const auto allowed = [&](std::uint32_t a, std::uint32_t b) {
        return !(scene.is_static[a] && scene.is_static[b]) && columns.allows(a, b);
    };
    std::vector<std::uint32_t> order(boxes.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::sort(order, {}, [&](std::uint32_t body) { return boxes[body].min.x(); });
    std::vector<BodyPair> pairs;
    for (std::size_t i = 0; i < order.size(); ++i)
        for (std::size_t j = i + 1; j < order.size() && boxes[order[j]].min.x() <= boxes[order[i]].max.x(); ++j)
            if (boxes[order[i]].overlaps(boxes[order[j]]) && allowed(order[i], order[j]))
                pairs.push_back({std::min(order[i], order[j]), std::max(order[i], order[j])});
    std::ranges::sort(pairs);
    return pairs;
}

} // namespace oncollide::tools
