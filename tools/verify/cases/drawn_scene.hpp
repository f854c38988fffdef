#pragma once
#include <cstdint>

#include <oncollide/pipeline/settings.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

/// A small random scene with all kinds of geometry, and settings for it.
struct DrawnScene {
    Scene scene; ///< two to four bodies, which drift for three frames
    Settings settings;
};

/// Three of four scenes are on a grid of 1/8, rotated by quarter turns, where touching is common; the others use
/// arbitrary coordinates. Equal seeds give equal scenes on every platform with the same standard library.
DrawnScene draw_scene(std::uint64_t seed);

} // namespace oncollide::tools
