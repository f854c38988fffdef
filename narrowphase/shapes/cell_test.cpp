#include <oncollide/narrowphase/shapes/cell_test.hpp>

#include <algorithm>
#include <limits>
#include <span>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/flat_triangles.hpp>
#include <oncollide/narrowphase/exact/triangle_gap.hpp>
#include <oncollide/scenes/model/box_corners.hpp>

namespace oncollide {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The gap between the triangle and the cell along the axes; negative if there is none.
double gap_along_axes(const Aabb& cell, const TrianglePoints& t)
{
    const Vector3d low = t[0].cwiseMin(t[1]).cwiseMin(t[2]), high = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
    return std::max((low - cell.max).maxCoeff(), (cell.min - high).maxCoeff());
}

bool parted_along_axes(const Aabb& cell, const TrianglePoints& t)
{
    for (int i = 0; i < 3; ++i)
        if (std::min({t[0][i], t[1][i], t[2][i]}) > cell.max[i] || std::max({t[0][i], t[1][i], t[2][i]}) < cell.min[i])
            return true;
    return false;
}

/// True if all corners of the cell are strictly on one side of the triangle's plane.
bool parted_by_plane(const Aabb& cell, const TrianglePoints& t)
{
    const int first = orient3d(t[0], t[1], t[2], corner_of(cell, 0));
    if (first == 0) return false;
    for (unsigned k = 1; k < 8; ++k)
        if (orient3d(t[0], t[1], t[2], corner_of(cell, k)) != first) return false;
    return true;
}

/// True if, in the projection along an axis, the line of an edge separates the cell from the triangle.
bool parted_by_edges(const Aabb& cell, const TrianglePoints& t)
{
    for (int axis = 0; axis < 3; ++axis) {
        std::array<Vector2d, 4> square;
        for (unsigned k = 0; k < 4; ++k) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            square[k] = {k & 1 ? cell.max[u] : cell.min[u], k & 2 ? cell.max[v] : cell.min[v]};
        }
        for (std::size_t e = 0; e < 3; ++e) {
            const Vector2d p = projected(t[e], axis), q = projected(t[(e + 1) % 3], axis);
            const int first = orient2d(p, q, square[0]);
            if (first == 0 || orient2d(p, q, square[1]) != first || orient2d(p, q, square[2]) != first ||
                orient2d(p, q, square[3]) != first)
                continue;
            if (orient2d(p, q, projected(t[(e + 2) % 3], axis)) != first) return true;
        }
    }
    return false;
}

/// Along a segment the squared distance is convex, and quadratic between the planes of the cell's faces.
NearestPoints segment_nearest(const Aabb& cell, const Vector3d& from, const Vector3d& to)
{
    const Vector3d along = to - from;
    const auto in_cell = [&](const Vector3d& p) -> Vector3d { return p.cwiseMax(cell.min).cwiseMin(cell.max); };
    NearestPoints nearest{{}, {}, std::numeric_limits<double>::infinity()};
    const auto take = [&](const Vector3d& p) {
        const Vector3d q = in_cell(p);
        const double distance = (p - q).norm() * (1 + 0x1p-50);
        if (distance < nearest.distance) nearest = {q, p, distance};
    };
    take(from), take(to);
    if (along.isZero(0)) return nearest;
    std::array<double, 8> cuts{}; // from 0 to 1
    std::size_t count = 1;
    for (int i = 0; i < 3; ++i)
        for (const double plane : {cell.min[i], cell.max[i]})
            if (const double s = (plane - from[i]) / along[i]; s > 0 && s < 1) {
                std::size_t k = count++;
                for (; cuts[k - 1] > s; --k) cuts[k] = cuts[k - 1];
                cuts[k] = s;
            }
    cuts[count++] = 1;
    for (std::size_t k = 0; k + 1 < count; ++k) {
        const double middle = 0.5 * (cuts[k] + cuts[k + 1]);
        const Vector3d p = from + middle * along, out = p - in_cell(p);
        const Vector3d moves = (out.array() != 0).select(along, 0.0);
        const double slope2 = moves.squaredNorm();
        if (slope2 > 0) take(from + std::clamp(middle - out.dot(moves) / slope2, cuts[k], cuts[k + 1]) * along);
    }
    return nearest;
}

TrianglePoints face_of(const CellCorners& corners, std::size_t face)
{
    const auto& [a, b, c] = box_faces[face];
    return {corners[a], corners[b], corners[c]};
}

} // namespace

CellCorners corners_of(const Aabb& cell)
{
    CellCorners corners;
    for (unsigned k = 0; k < 8; ++k) corners[k] = corner_of(cell, k);
    return corners;
}

bool cell_meets(const Aabb& cell, const TrianglePoints& t)
{
    // Two polytopes are apart if a face of either or an edge of each separates them. A triangle without area has only
    // edges; then the cell's own axes and the axes across the edges suffice.
    if (parted_along_axes(cell, t)) return false;
    return !parted_by_plane(cell, t) && !parted_by_edges(cell, t);
}

double cell_distance_at_most(const Aabb& cell, const TrianglePoints& t)
{
    double least2 = std::numeric_limits<double>::infinity();
    for (const Vector3d& p : t) least2 = std::min(least2, (p - p.cwiseMax(cell.min).cwiseMin(cell.max)).squaredNorm());
    return std::sqrt(least2) * (1 + 0x1p-50);
}

NearestPoints cell_nearest(const Aabb& cell, const TrianglePoints& t, double rounding)
{
    if (t[1] == t[2]) return segment_nearest(cell, t[0], t[1]);
    NearestPoints nearest{{}, {}, std::numeric_limits<double>::infinity()};
    for (const Vector3d& p : t) {
        const Vector3d q = p.cwiseMax(cell.min).cwiseMin(cell.max);
        const double distance = (p - q).norm() * (1 + 0x1p-50);
        if (distance < nearest.distance) nearest = {q, p, distance};
    }
    if (t[0] == t[1] && t[0] == t[2]) return nearest;
    const CellCorners corners = corners_of(cell);
    std::array<TrianglePoints, 12> faces;
    std::size_t count = 0;
    for (std::size_t f = 0; f < 12; ++f) {
        // Only faces that the triangle is in front of can be nearest.
        const int axis = 2 - static_cast<int>(f / 4);
        const bool high = f % 4 >= 2;
        const bool in_front = std::ranges::any_of(
            t, [&](const Vector3d& p) { return high ? p[axis] > cell.max[axis] : p[axis] < cell.min[axis]; });
        if (in_front) faces[count++] = face_of(corners, f);
    }
    const NearestPoints found = nearest_points(std::span(faces).first(count), t, rounding);
    return found.distance < nearest.distance ? found : nearest;
}

double cell_gap(const Aabb& cell, const TrianglePoints& t, double rounding)
{
    const double along_axes = gap_along_axes(cell, t) * (1 - 0x1p-50);
    if (along_axes > 0) return along_axes;
    const double gap = cell_nearest(cell, t, 0.5 * rounding).distance - rounding;
    if (gap > 0) return gap;
    return least_possible_gap({cell.min, cell.max, {cell.min.x(), cell.max.y(), cell.min.z()}}, t);
}

bool cells_meet(const Aabb& cell, const CellCorners& other)
{
    for (std::size_t f = 0; f < 12; ++f)
        if (cell_meets(cell, face_of(other, f))) return true;
    // No face of the other cell touches this cell, which is then completely inside or outside.
    const Vector3d p = cell.centre();
    for (std::size_t f = 0; f < 12; ++f) {
        const auto& [a, b, c] = box_faces[f];
        if (orient3d(other[a], other[b], other[c], p) > 0) return false;
    }
    return true;
}

NearestPoints cells_nearest(const Aabb& cell, const CellCorners& other, double rounding)
{
    NearestPoints nearest{{}, {}, std::numeric_limits<double>::infinity()};
    for (std::size_t f = 0; f < 12; ++f) {
        const NearestPoints found = cell_nearest(cell, face_of(other, f), rounding);
        if (found.distance < nearest.distance) nearest = found;
    }
    return nearest;
}

} // namespace oncollide
