#pragma once
#include <array>
#include <span>

#include <oncollide/narrowphase/spheres/cell_key.hpp>
#include <oncollide/narrowphase/spheres/octant_kernel.hpp>
#include <oncollide/narrowphase/spheres/surface.hpp>

namespace oncollide {

OctantCell octant_cell(const RootCell& root, CellKey cell);

/// The octants inside a solid (Surface::inside), except grey ones: the surface does not enter them, so their centres
/// decide. None without planes.
unsigned octants_inside(std::span<const std::array<double, 4>> planes, const OctantCell& cell, unsigned grey);

} // namespace oncollide
