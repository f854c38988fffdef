#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include <oncollide/narrowphase/spheres/primitive.hpp>
#include <oncollide/scenes/geometry.hpp>

namespace oncollide {

/// The root cell of a geometry's sphere-tree, known from its bounds alone.
struct RootCell {
    Eigen::Vector3d centre; ///< geometry frame; kept in double, everything else is relative to it
    std::array<float, 3>
        half;      ///< half-extents, rounded up; at least 1/64 of the largest, so that flat bodies get real cells
    double radius; ///< radius of the sphere around the cell
    double scale;  ///< largest half-extent: the M of every rounding argument
    /// An octant test may report grey this far outside a cell: 2^-18 M. The test's octants are grown by it.
    double slack() const { return scale * 0x1p-18; }
    /// Upper bound of the distance of a grey cell from the surface. Octants grow by slack, every axis of the test
    /// rounds by less than slack again, and the worst corner of a box against a triangle multiplies this by at most
    /// sqrt 3.
    double test_error() const { return 4 * slack(); }
};

/// The root cell around a geometry with these bounds.
RootCell root_cell_around(const Aabb& bounds);

/// A geometry's surface for backends: float copies relative to the root cell's centre. Made when a test first goes
/// below the root.
struct Surface {
    RootCell root;
    bool boxes = false;                ///< primitives are solid axis-aligned boxes, not triangles
    std::vector<Primitive> primitives; ///< in the order of the mesh's triangles or the map's cells
    /// Planes around a solid convex body, (n, d) with n . x <= d inside, relative to the root's centre. Cells inside
    /// all of them are inside the body. Empty: surface only.
    std::vector<std::array<double, 4>> inside;

    std::size_t bytes() const
    {
        return primitives.capacity() * sizeof(Primitive) + inside.capacity() * sizeof(inside[0]);
    }
};

// The surface of a mesh, of a map's cells, and of a closed convex mesh as a solid. Cost: about 10 ns per primitive.
Surface mesh_surface(const Mesh& mesh, const RootCell& root);
Surface map_surface(const OccupancyMap& map, const RootCell& root);
Surface solid_surface(const Mesh& convex, const RootCell& root);

} // namespace oncollide
