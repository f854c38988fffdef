#include "verify/cases/placed_body.hpp"

#include <oncollide/samples/generators.hpp>

namespace oncollide::tools {

using Eigen::Vector3d;

OccupancyMap one_cell(double side)
{
    const MapCell cell{0, 0, 0, 1};
    return make_occupancy_map("cell", side, {&cell, 1});
}

PlacedBody make_box(BoxForm form, const GridFrame& frame, const Place& low, const Place& high)
{
    const Vector3d size = frame.point(high) - frame.point(low);
    const Eigen::Isometry3d corner = frame.at(low), middle = moved_to(frame.offset + frame.point(low) + size / 2);
    if (form == BoxForm::cell) return {one_cell(size.x()), corner};
    if (form == BoxForm::shape) return {Shape(Box{size / 2}), middle};
    if (form == BoxForm::mesh) return {make_box_mesh(size / 2), middle};
    ConvexHull hull;
    for (int k = 0; k < 8; ++k) hull.points.push_back(size.cwiseProduct(Vector3d(k & 1, k >> 1 & 1, k >> 2)));
    return {Shape(hull), corner};
}

PlacedBody make_triangle(const GridFrame& frame, const PlaceTriangle& t)
{
    return {make_mesh("triangle", {frame.point(t[0]), frame.point(t[1]), frame.point(t[2])}, {{0, 1, 2}}),
            moved_to(frame.offset)};
}

} // namespace oncollide::tools
