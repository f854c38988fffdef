#pragma once
#include <oncollide/base/aabb.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

/// True if the cell, a solid box, and the triangle have a point in common. Exact for the coordinates as stored;
/// touching counts. Cost: 10 to 100 ns. Source: Akenine-Möller, "Fast 3D triangle-box overlap testing", JGT 2001, with
/// exact signs.
bool cell_meets(const Aabb& cell, const TrianglePoints& triangle);

/// The nearest points of a cell and a triangle that do not meet, the cell's first, and their distance, which errs by at
/// most `rounding`, metres.
NearestPoints cell_nearest(const Aabb& cell, const TrianglePoints& triangle, double rounding);

/// Upper bound of the distance, from the corners of the triangle.
double cell_distance_at_most(const Aabb& cell, const TrianglePoints& triangle);

/// A lower bound of the distance of a cell and a triangle that do not meet: > 0 unless doubles cannot express it.
/// @param rounding  at least twice the error of a corner as placed
double cell_gap(const Aabb& cell, const TrianglePoints& triangle, double rounding);

/// True if two cells have a point in common. The second is given by its corners: bits 0, 1 and 2 of the index select
/// the side along x, y and z of its own frame.
using CellCorners = std::array<Eigen::Vector3d, 8>;
bool cells_meet(const Aabb& cell, const CellCorners& other);
NearestPoints cells_nearest(const Aabb& cell, const CellCorners& other, double rounding);

CellCorners corners_of(const Aabb& cell);

} // namespace oncollide
