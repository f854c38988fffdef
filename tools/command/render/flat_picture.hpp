#pragma once
#include <oncollide/narrowphase/gl/picture.hpp>

#include "render/png.hpp"

namespace oncollide::tools {

/// Draws the bodies of a picture on the CPU, for builds without OpenGL: opaque, one light at the camera, four samples
/// per pixel. Draws no spheres, no lines, and no triangle that reaches behind the eye.
Image draw_bodies(const Picture& picture);

} // namespace oncollide::tools
