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

/// Two moving bodies of all kinds, with a clearance and a mode.
struct DrawnSweep {
    GeometryData a, b;
    RigidMotion motion_a, motion_b;
    Settings settings;
};

/// Draws them as draw_scene() does. Motions are linear, screws or sequences of both, some of them fast, and rest; on
/// the grid, bodies often touch at one instant, at an end, or all the time.
DrawnSweep draw_sweep(std::uint64_t seed);

} // namespace oncollide::tools
