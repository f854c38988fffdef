#pragma once
#include <array>
#include <cstdint>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/mesh.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>
#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

// Generated geometry. Deterministic for equal arguments, on every platform. All throw Error{usage} for counts or sizes
// that make no geometry.

/// 12 triangles; `half` are the half-extents. Closed.
ONCOLLIDE_API Mesh make_box_mesh(const Eigen::Vector3d& half);
/// The same with faces of `cells` x `cells` cells of two triangles each, which share no vertices across the edges.
ONCOLLIDE_API Mesh make_box_mesh(const Eigen::Vector3d& half, int cells);
/// A subdivided octahedron for 8 * 4^k triangles, else bands of latitude with exactly `triangles`; one less if it is
/// odd, as a closed mesh has an even number (and 8 for 8 to 11). Closed.
ONCOLLIDE_API Mesh make_sphere_mesh(double radius, int triangles);
/// Ring radius `major`, tube radius `minor`, around z. `triangles`, or one less when odd; at least 18. Closed.
ONCOLLIDE_API Mesh make_torus_mesh(double major, double minor, int triangles);
/// (p, q) torus knot as a closed tube; p and q coprime. `triangles`, or one less when odd; at least 18.
ONCOLLIDE_API Mesh make_torus_knot_mesh(int p, int q, double major, double minor, double tube, int triangles);
/// Spur gear around z with a bore: `teeth` trapezoid teeth between root and tip radius. Closed.
ONCOLLIDE_API Mesh make_gear_mesh(int teeth, double root_radius, double tip_radius, double thickness,
                                  double bore_radius);
/// The flat square [-size/2, size/2]^2 at z = 0, `cells` x `cells` squares. Open.
ONCOLLIDE_API Mesh make_sheet_mesh(double size, int cells);
/// The same with two sides, and other numbers of cells along them.
ONCOLLIDE_API Mesh make_sheet_mesh(const Eigen::Vector2d& size, const std::array<int, 2>& cells);
/// Height field over [-size/2, size/2]^2, `cells` x `cells` squares, fractal noise of given height. Open.
ONCOLLIDE_API Mesh make_terrain_mesh(double size, double height, int cells, std::uint64_t seed);
/// `count` isolated triangles of length `length` and width length / aspect, in random directions in a cube of side
/// `size`.
ONCOLLIDE_API Mesh make_needles_mesh(int count, double length, double aspect, double size, std::uint64_t seed);
/// `count` random triangles of edge about `edge` in a cube of side `size`: open, with self-intersections.
ONCOLLIDE_API Mesh make_soup_mesh(int count, double edge, double size, std::uint64_t seed);

/// Hills over [0, cells_x spacing] x [0, cells_y spacing], at most `height` high; exact at 2 bytes or fewer. Cost: 30
/// ns per cell.
ONCOLLIDE_API Terrain make_hills(std::uint32_t cells_x, std::uint32_t cells_y, double spacing, double height,
                                 std::uint64_t seed);
/// The cells [x, x + size) x [y, y + size) of make_hills(cells, cells, ...) as a mesh; such meshes together make up the
/// hills.
ONCOLLIDE_API Mesh make_hills_mesh(std::uint32_t cells, double spacing, double height, std::uint64_t seed,
                                   std::uint32_t x, std::uint32_t y, std::uint32_t size);

/// A building of about `rooms` x `rooms` rooms with furniture at the given resolution (m).
ONCOLLIDE_API OccupancyMap make_building_map(int rooms, double resolution, std::uint64_t seed);

} // namespace oncollide
