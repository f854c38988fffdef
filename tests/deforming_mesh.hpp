#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

enum class DeformingWay { grow, fold, swing, collapse, wave, shiver, scatter };
constexpr int deformations = 7;

/// Positions of the vertices of a mesh that deforms, about 1 m large at rest.
/// @param time  in periods of about 1
inline std::vector<Eigen::Vector3d> deformed(const std::vector<Eigen::Vector3d>& rest, DeformingWay how, double time)
{
    using Eigen::Vector3d;
    const double turn = 2 * std::numbers::pi * time, wave = std::sin(turn);
    const auto seed = static_cast<std::uint64_t>(1000 * time);
    std::vector<Vector3d> moved = rest;
    for (std::uint64_t v = 0; v < moved.size(); ++v) {
        Vector3d& p = moved[v];
        const Vector3d random(u01(seed, v, 0) - 0.5, u01(seed, v, 1) - 0.5, u01(seed, v, 2) - 0.5);
        switch (how) {
        case DeformingWay::grow:
            p *= 1 + 0.6 * wave;
            break;
        case DeformingWay::fold: // onto itself where the angle is a half turn
            if (p.x() > 0)
                p = Eigen::AngleAxisd(std::numbers::pi * (1 + wave) / 2 * 1.01, Vector3d::UnitY()).toRotationMatrix() *
                    p;
            break;
        case DeformingWay::swing:
            p = Eigen::AngleAxisd(wave, Vector3d::UnitX()).toRotationMatrix() * (p - Vector3d(0, 0, 2)) +
                Vector3d(0, 0, 2);
            break;
        case DeformingWay::collapse: // to a plane, to a line, to a point, and back
            p.x() *= std::max(0.0, std::min(1.0, 1 + wave)), p.z() *= std::max(0.0, wave);
            p.y() *= std::max(0.0, std::min(1.0, 1.5 + 1.6 * wave));
            break;
        case DeformingWay::wave:
            p.z() += 0.2 * std::sin(6 * p.x() + turn) * std::cos(5 * p.y() - turn);
            break;
        case DeformingWay::shiver:
            p += 0.02 * random;
            break;
        case DeformingWay::scatter: // triangles far larger than at rest
            p = 1.5 * random;
        }
    }
    return moved;
}

} // namespace oncollide
