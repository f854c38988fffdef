#pragma once
#include <string>
#include <vector>

#include "render/png.hpp"
#include "self/self_places.hpp"

namespace oncollide::tools {

/// The mesh with the triangles that meet in red, from the side that shows most of them; if there are any, also a
/// close-up of the first place. Drawn without OpenGL.
Image draw_self(const Mesh& mesh, const std::vector<SelfPlace>& places);

/// Writes the mesh as a page in 3D (view/view_page.hpp). Each place is two bodies that collide, so they are red and in
/// the list of pairs: the lower triangles of all its pairs, and the higher ones.
/// @param most_bytes  size limit of the page
/// Returns a summary of the file. Throws Error{no_input} without three.js.
std::string write_self_view(const std::string& file, const std::string& name, const Mesh& mesh,
                            const std::vector<SelfPlace>& places, std::size_t most_bytes);

} // namespace oncollide::tools
