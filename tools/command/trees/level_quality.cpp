#include "trees/level_quality.hpp"

#include "trees/surface_cover.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

/// Directions spread evenly over the unit sphere: a golden-angle spiral.
std::vector<Vector3d> even_directions(int count)
{
    std::vector<Vector3d> directions;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1.0) / count, turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
        directions.emplace_back(std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z);
    }
    return directions;
}

/// Directions to the corners of a cube.
std::vector<Vector3d> corner_directions()
{
    std::vector<Vector3d> directions;
    for (int k = 0; k < 8; ++k) directions.emplace_back(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
    return directions;
}

class Judge {
public:
    Judge(const SurfaceIndex& index, const QualityOptions& options)
        : index_(index), closed_(options.closed), directions_(even_directions(options.directions)),
          corners_(corner_directions())
    {
    }

    Reach operator()(const CoveringVolume& volume) const
    {
        Reach reach;
        // Directions straight away from the surface, and the opposite ones.
        const Vector3d off = volume.centre - index_.nearest(volume.centre).point;
        if (off.norm() > 1e-9 * volume.radius())
            for (const double sign : {1.0, -1.0}) look(volume, sign * off, reach);
        if (!volume.ball)
            for (const Vector3d& corner : corners_) look(volume, volume.axes * corner, reach);
        for (const Vector3d& direction : directions_) look(volume, direction, reach);
        return reach;
    }

private:
    void look(const CoveringVolume& volume, const Vector3d& direction, Reach& reach) const
    {
        const Vector3d point = volume.boundary(direction);
        const double distance = index_.nearest(point, closed_ ? reach.beyond : reach.either).distance;
        reach.either = std::max(reach.either, distance);
        if (closed_ && distance > reach.beyond && !index_.inside(point)) reach.beyond = distance;
    }

    const SurfaceIndex& index_;
    bool closed_;
    std::vector<Vector3d> directions_, corners_;
};

} // namespace

LevelQuality judge_level(const Mesh& mesh, const SurfaceIndex& index, std::span<const CoveringVolume> volumes,
                         const QualityOptions& options)
{
    LevelQuality quality;
    quality.reaches.resize(volumes.size());
    const Judge judge(index, options);
    parallel_chunks(volumes.size(), 64, options.threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) quality.reaches[i] = judge(volumes[i]);
    });
    for (const Reach& reach : quality.reaches) {
        quality.worst = {std::max(quality.worst.either, reach.either), std::max(quality.worst.beyond, reach.beyond)};
        quality.mean.either += reach.either / double(volumes.size());
        quality.mean.beyond += reach.beyond / double(volumes.size());
    }
    for (const CoveringVolume& v : volumes) quality.volume += v.volume();
    const SurfaceCover cover(mesh, index, volumes);
    quality.uncovered = cover.uncovered_area(quality.open_triangles);
    quality.outside = cover.points_outside(options.points, quality.points);
    return quality;
}

} // namespace oncollide::tools
