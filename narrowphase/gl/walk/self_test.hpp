#pragma once
#include <string>

#include <oncollide/narrowphase/gl/walk/mesh_walks.hpp>

namespace oncollide::gl::walk {

/// Decides pairs of two small meshes and of two boxes a billionth of their size apart, or into each other, and compares
/// each result with exact tests of all triangles. Returns the first fault; empty: there is none. It finds drivers that
/// compile a shader wrongly or compute doubles as floats. Cost: about 10 ms on the CPU.
std::string fault_of(MeshWalks& walks);

} // namespace oncollide::gl::walk
