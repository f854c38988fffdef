#pragma once
#include <cstddef>
#include <span>

#include "triangle_tree.hpp"
#include <oncollide/narrowphase/tree_spheres.hpp>

namespace oncollide::tools {

/// How well the spheres of one level stand for a mesh. Lengths in metres.
struct SphereQuality {
    std::size_t spheres = 0;
    /// The over-reach of a sphere is the farthest that one of its points is from the surface, on either side of it.
    double worst = 0, mean = 0;
    /// The same of its points outside the body: how far it stands out. Of closed meshes; 0 for others.
    double worst_beyond = 0, mean_beyond = 0;
    double volume = 0;                   ///< of the spheres, what overlaps counted as often
    std::size_t open_triangles = 0;      ///< not wholly in spheres
    double uncovered = 0;                ///< area in no sphere, m^2
    std::size_t points = 0, outside = 0; ///< of the surface: looked at, and in no sphere
};

struct QualityOptions {
    bool closed = false;         ///< the mesh has an inside
    int directions = 60;         ///< points of a sphere that are looked at, besides those opposite to the surface
    std::size_t points = 50'000; ///< of the surface, spread by area; every corner and centre besides
    int threads = 1;
};

/// Over-reach is looked for at points of the boundary of each sphere, so it is that much from below; a sphere's points
/// are never farther than its radius and the distance of its centre together.
/// Coverage is decided twice: at points, and for whole triangles, which are halved until each piece is in one sphere.
/// A sphere with a slab is what both leave. `spheres` lie in the mesh's frame.
/// Cost: about 20 microseconds a sphere, and as much a triangle that spheres meet in.
SphereQuality judge_spheres(const Mesh& mesh, const TriangleTree& tree, std::span<const TreeSphere> spheres,
                            const QualityOptions& options = {});

} // namespace oncollide::tools
