#include "sphere_quality.hpp"

#include "sphere_cover.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

/// Even on the unit sphere: a spiral by the golden angle.
std::vector<Vector3d> even_directions(int count)
{
    std::vector<Vector3d> directions;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1.0) / count, turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
        directions.emplace_back(std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z);
    }
    return directions;
}

/// The point of the boundary in that direction; where the slab cuts it off, the rim of the disc or, `inner`, its face.
Vector3d boundary_point(const TreeSphere& s, const Vector3d& direction, bool inner)
{
    const double along = s.normal.dot(direction);
    if (std::abs(along) * s.radius <= s.half) return s.centre + s.radius * direction;
    const Vector3d across = direction - along * s.normal;
    const double rim = std::sqrt(std::max(0.0, s.radius * s.radius - s.half * s.half));
    const double length = across.norm();
    const double scale = inner || length < 1e-9 ? s.radius : rim / length; // shorter is rounding, in any direction
    return s.centre + scale * across + std::copysign(s.half, along) * s.normal;
}

struct Reach {
    double either = 0, beyond = 0;
};

class Judge {
public:
    Judge(const TriangleTree& tree, const QualityOptions& options)
        : tree_(tree), closed_(options.closed), directions_(even_directions(options.directions))
    {
    }

    Reach operator()(const TreeSphere& sphere) const
    {
        Reach reach;
        // Straight away from the surface, and straight through it.
        const Vector3d off = sphere.centre - tree_.nearest(sphere.centre).point;
        if (off.norm() > 1e-9 * sphere.radius)
            for (const double sign : {1.0, -1.0}) look(sphere, sign * off.normalized(), false, reach);
        for (const double sign : {1.0, -1.0}) look(sphere, sign * sphere.normal, false, reach);
        for (std::size_t i = 0; i < directions_.size(); ++i) look(sphere, directions_[i], i % 2, reach);
        return reach;
    }

private:
    void look(const TreeSphere& sphere, const Vector3d& direction, bool inner, Reach& reach) const
    {
        const Vector3d point = boundary_point(sphere, direction, inner);
        const double distance = tree_.nearest(point, closed_ ? reach.beyond : reach.either).distance;
        reach.either = std::max(reach.either, distance);
        if (closed_ && distance > reach.beyond && !tree_.inside(point)) reach.beyond = distance;
    }

    const TriangleTree& tree_;
    bool closed_;
    std::vector<Vector3d> directions_;
};

/// Of a ball between two planes as far from its centre.
double volume_of(const TreeSphere& s)
{
    const double h = std::min(s.half, s.radius);
    return 2 * std::numbers::pi * (s.radius * s.radius * h - h * h * h / 3);
}

} // namespace

SphereQuality judge_spheres(const Mesh& mesh, const TriangleTree& tree, std::span<const TreeSphere> spheres,
                            const QualityOptions& options)
{
    SphereQuality quality;
    quality.spheres = spheres.size();
    const Judge judge(tree, options);
    std::vector<Reach> reaches(spheres.size());
    parallel_chunks(spheres.size(), 64, options.threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) reaches[i] = judge(spheres[i]);
    });
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        quality.worst = std::max(quality.worst, reaches[i].either);
        quality.worst_beyond = std::max(quality.worst_beyond, reaches[i].beyond);
        quality.mean += reaches[i].either / double(spheres.size());
        quality.mean_beyond += reaches[i].beyond / double(spheres.size());
        quality.volume += volume_of(spheres[i]);
    }
    const SphereCover cover(mesh, tree, spheres);
    quality.uncovered = cover.uncovered_area(quality.open_triangles);
    quality.outside = cover.points_outside(options.points, quality.points);
    return quality;
}

} // namespace oncollide::tools
