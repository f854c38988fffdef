#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "trees/bounding_volume.hpp"
#include "trees/surface_index.hpp"

namespace oncollide::tools {

/// The over-reach of a volume: the largest distance of its points from the surface. Metres.
struct Reach {
    double either = 0; ///< distance on either side of the surface
    double beyond = 0; ///< only for points outside the body; 0 if the mesh is not closed
};

/// How closely the volumes of one level of a tree fit a mesh.
struct LevelQuality {
    std::vector<Reach> reaches; ///< by volume
    Reach worst, mean;
    double volume = 0;                   ///< sum over all volumes, m^3
    std::size_t open_triangles = 0;      ///< triangles not wholly in volumes
    double uncovered = 0;                ///< area in no volume, m^2
    std::size_t points = 0, outside = 0; ///< points of the surface that were tested; outside: points that are in no
                                         ///< volume
};

struct QualityOptions {
    bool closed = false;         ///< the mesh has an inside
    int directions = 60;         ///< sample points per volume, besides corners and points facing away from the surface
    std::size_t points = 50'000; ///< number of points of the surface, spread by area, besides all vertices and centres
    int threads = 1;
};

/// Over-reach is measured at sample points on each volume's boundary, so it is a lower bound; an upper bound is the
/// volume's radius plus its centre's distance from the surface.
/// Coverage is tested twice: at points, and for whole triangles, which are halved until each piece is in one volume.
/// Volumes are in the mesh's frame. Cost: about 20 microseconds per volume, and the same per triangle that several
/// volumes cover.
LevelQuality judge_level(const Mesh& mesh, const SurfaceIndex& index, std::span<const CoveringVolume> volumes,
                         const QualityOptions& options = {});

} // namespace oncollide::tools
