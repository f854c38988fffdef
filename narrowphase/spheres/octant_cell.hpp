#pragma once
#include <array>
#include <span>

#include <oncollide/narrowphase/spheres/cell_key.hpp>
#include <oncollide/narrowphase/spheres/octant_kernel.hpp>
#include <oncollide/narrowphase/spheres/surface.hpp>

namespace oncollide {

OctantCell octant_cell(const RootCell& root, CellKey cell);

/// The octants, grey ones apart, that lie inside a solid (Surface::inside): the surface does not enter them, so their
/// centres tell. None without planes.
unsigned octants_inside(std::span<const std::array<double, 4>> planes, const OctantCell& cell, unsigned grey);

} // namespace oncollide
