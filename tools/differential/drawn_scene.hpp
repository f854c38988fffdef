#pragma once
#include <cstdint>

#include <oncollide/pipeline/settings.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

/// A small scene of all kinds of geometry and settings for it, drawn by lot.
struct DrawnScene {
    Scene scene; ///< two to four bodies, which drift for three frames
    Settings settings;
};

/// Three of four are on a grid of 1/8, rotated by quarter turns, where touching is common; the others lie anywhere.
/// The same for the same seed on every platform that has the same standard library.
DrawnScene draw_scene(std::uint64_t seed);

} // namespace oncollide::tools
