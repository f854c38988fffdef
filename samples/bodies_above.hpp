#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <oncollide/scenes/model/terrain.hpp>
#include <oncollide/scenes/scene_builder.hpp>

namespace oncollide {

// Small bodies in a large environment, for the catalogue and the benchmarks of environments. Private to the project.

/// Points of a geometry's surface, spread over all of it; fewer than 40,000 for a map or a terrain.
std::vector<Eigen::Vector3d> surface_points(const GeometryData& geometry);

/// The height of a terrain with rising diagonals at a place; infinite outside of it, where no body should come.
double height_at(const Terrain& terrain, double x, double y);

/// A knot, a ring and a sphere: meshes of about a metre, of 6,000 to 13,000 triangles.
std::vector<GeometryId> add_meshes_of_a_metre(SceneInfo& scene);

/// Adds `count` bodies that cycle through these geometries, at some of the points and slightly above them. They drift
/// and rotate slowly and stay within 2 m of `bounds`.
void add_bodies_above(SceneBuilder scene, const std::vector<Eigen::Vector3d>& points, const Aabb& bounds,
                      const std::vector<GeometryId>& of, int count, std::uint64_t seed);

} // namespace oncollide
