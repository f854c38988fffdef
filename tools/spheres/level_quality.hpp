#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "peers/bounding_volume.hpp"
#include "spheres/surface_index.hpp"

namespace oncollide::tools {

/// The over-reach of a volume: the farthest that one of its points is from the surface. Metres.
struct Reach {
    double either = 0; ///< on either side of the surface
    double beyond = 0; ///< of its points outside the body: how far it stands out. Of closed meshes; 0 for others
};

/// How well the volumes of one level of a tree stand for a mesh.
struct LevelQuality {
    std::vector<Reach> reaches; ///< by volume
    Reach worst, mean;
    double volume = 0;                   ///< of all, what overlaps counted as often, m^3
    std::size_t open_triangles = 0;      ///< not wholly in volumes
    double uncovered = 0;                ///< area in no volume, m^2
    std::size_t points = 0, outside = 0; ///< of the surface: looked at, and in no volume
};

struct QualityOptions {
    bool closed = false; ///< the mesh has an inside
    int directions = 60; ///< points of a volume that are looked at, besides corners and those opposite to the surface
    std::size_t points = 50'000; ///< of the surface, spread by area; every corner and centre besides
    int threads = 1;
};

/// Over-reach is looked for at points of the boundary of each volume, so it is that much from below; a volume's points
/// are never farther than its radius and the distance of its centre together.
/// Coverage is decided twice: at points, and for whole triangles, which are halved until each piece is in one volume.
/// Volumes lie in the mesh's frame. Cost: about 20 microseconds a volume, and as much a triangle that volumes meet in.
LevelQuality judge_level(const Mesh& mesh, const SurfaceIndex& index, std::span<const CoveringVolume> volumes,
                         const QualityOptions& options = {});

} // namespace oncollide::tools
