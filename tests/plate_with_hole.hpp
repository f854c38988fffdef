#pragma once
#include <utility>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// A plate from low.z() to high.z() with a hole through it, as a wall with an opening or the frame of a window; plate and
/// hole are rectangles.
inline Mesh plate_with_hole(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Eigen::Vector3d& hole_low,
                            const Eigen::Vector3d& hole_high)
{
    std::vector<Eigen::Vector3d> v;
    for (const double z : {low.z(), high.z()})
        for (const auto& [l, h] : {std::pair(low, high), std::pair(hole_low, hole_high)})
            for (const auto& [x, y] :
                 {std::pair(l.x(), l.y()), std::pair(h.x(), l.y()), std::pair(h.x(), h.y()), std::pair(l.x(), h.y())})
                v.emplace_back(x, y, z);
    std::vector<Triangle> t;
    const auto quad = [&](unsigned a, unsigned b, unsigned c, unsigned d) {
        t.push_back({a, b, c}), t.push_back({a, c, d});
    };
    for (unsigned k = 0; k < 4; ++k) {
        const unsigned n = (k + 1) % 4;
        quad(k, n, 8 + n, 8 + k), quad(4 + n, 4 + k, 12 + k, 12 + n);
        quad(n, k, 4 + k, 4 + n), quad(8 + k, 8 + n, 12 + n, 12 + k);
    }
    return make_mesh("plate", std::move(v), std::move(t));
}

} // namespace oncollide
