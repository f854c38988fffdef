#pragma once
#include <oncollide/narrowphase/gl/picture.hpp>

#include "render/png.hpp"

namespace oncollide::tools {

/// Draws the bodies of a picture on the CPU, for builds without OpenGL: opaque, one light at the camera, four samples
/// per pixel. Spheres and lines are left out, and so are triangles that reach behind the eye.
Image draw_bodies(const Picture& picture);

} // namespace oncollide::tools
