#include <oncollide/narrowphase/spheres/octant_cell.hpp>

#include <algorithm>
#include <cmath>

namespace oncollide {

OctantCell octant_cell(const RootCell& root, CellKey key)
{
    const auto position = centre_of(key);
    const float scale = 1 / static_cast<float>(1u << level_of(key));
    OctantCell cell;
    for (int axis = 0; axis < 3; ++axis) {
        cell.half[axis] = root.half[axis] * scale;
        cell.centre[axis] = static_cast<float>(position[axis]) * cell.half[axis];
    }
    cell.slack = static_cast<float>(root.slack());
    return cell;
}

unsigned octants_inside(std::span<const std::array<double, 4>> planes, const OctantCell& cell, unsigned grey)
{
    if (planes.empty()) return 0;
    unsigned inside = 0;
    for (unsigned k = 0; k < 8; ++k) {
        if (grey >> k & 1) continue;
        double p[3];
        for (int axis = 0; axis < 3; ++axis)
            p[axis] = double(cell.centre[axis]) + (k >> axis & 1 ? 0.5 : -0.5) * double(cell.half[axis]);
        const bool in = std::all_of(planes.begin(), planes.end(), [&](const auto& plane) {
            return plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] <= plane[3];
        });
        if (in) inside |= 1u << k;
    }
    return inside;
}

} // namespace oncollide
