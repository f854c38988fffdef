// How a test of a pair takes a body.
#pragma once
#include <oncollide/narrowphase/model.hpp>

namespace oncollide::operand {

/// The cells of a map.
struct Cells {
    static MapTree& tree(Model& model) { return model.cells(); }
    static double error(const Model&) { return 0; } ///< error bound of its coordinates, metres
};
/// The triangles of a terrain.
struct Heights {
    static TerrainTree& tree(Model& model) { return model.heights(); }
    static double error(const Model& model) { return model.terrain()->error(); }
};
/// The triangles of a mesh. Its OBB tree must exist.
struct Triangles {
    static ObbTree& tree(Model& model) { return *model.obb_tree; }
    static double error(const Model&) { return 0; }
};
/// The surface of a box or a hull. Its OBB tree must exist.
struct Polytope : Triangles {};
/// A bounded shape as one solid.
struct Solid {
    static const ShapeTree& tree(Model& model) { return model.shape_tree(); }
    static double error(const Model&) { return 0; }
};

/// A half-space.
struct Plane {};

/// Hulls with more points are measured by the triangles of their surface: a solid hull scans all its points for each
/// direction.
constexpr std::uint32_t most_points = 1024;

} // namespace oncollide::operand
