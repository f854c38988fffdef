#include "bench/narrow/cloths.hpp"

#include <algorithm>
#include <cmath>

#include <oncollide/samples/generators.hpp>

namespace oncollide::tools {
namespace {

/// The cloth at a time: waves of a height of 2 cm run over it.
std::vector<Eigen::Vector3d> waving(const Mesh& rest, double time, double phase)
{
    std::vector<Eigen::Vector3d> moved = rest.vertices;
    for (Eigen::Vector3d& p : moved) {
        const double x = p.x(), y = p.y();
        p.z() = 0.02 * std::sin(17 * x + 5 * y + time + phase) * std::cos(11 * y - 4 * x - 0.7 * time);
        p.x() += 0.004 * std::sin(23 * y + time);
    }
    return moved;
}

} // namespace

Mesh ClothScene::mesh(int which, int frame) const
{
    const auto now = vertices(which, frame);
    return make_mesh("cloth", {now.begin(), now.end()}, rest_[which].triangles);
}

std::vector<ClothScene> cloth_scenes(int triangles, int frames)
{
    constexpr double step = 0.15; // of the waves' phase, in a frame
    const Mesh cloth = make_sheet_mesh(1, std::max(1, int(std::lround(std::sqrt(triangles / 2.0)))));
    Mesh ball = make_sphere_mesh(0.055, 1000);
    for (Eigen::Vector3d& p : ball.vertices) p += Eigen::Vector3d(0.13, -0.21, 0.01);
    ball = make_mesh("ball", std::move(ball.vertices), std::move(ball.triangles));
    std::vector<ClothScene> scenes;
    scenes.emplace_back("a small body", 1, cloth, std::move(ball));
    scenes.emplace_back("two cloths", 2, cloth, cloth);
    for (ClothScene& scene : scenes)
        for (int which = 0; which < scene.deforming(); ++which)
            for (int frame = 0; frame <= frames; ++frame) scene.add_frame(which, waving(cloth, step * frame, which));
    return scenes;
}

} // namespace oncollide::tools
