#pragma once
#include <functional>
#include <string>

#include "verify/cases/drawn_scene.hpp"
#include "verify/trials/seeds.hpp"

namespace oncollide::tools {

/// Plays the scene. Checks every pair of every frame against the truth (truth.hpp), and the
/// run against runs that must give the same results: with another number of threads, without coherence, with another
/// broad phase, with the bodies in reverse. Returns the first fault; empty: none.
/// Cost: about 2 ms.
std::string fault_in(const DrawnScene& drawn);

/// The first fault in the scenes of `count` seeds from `first` on. Calls done() once per seed, never concurrently.
FirstFault first_faulty_scene(std::uint64_t first, std::uint64_t count, int threads, const std::function<void()>& done);

/// The smallest scene and plainest settings that still have the fault, found by removing one thing after another.
DrawnScene shrunk(DrawnScene drawn, const std::function<bool(const DrawnScene&)>& faulty);

/// The options of `oncollide run` for these settings.
std::string options_of(const Settings& settings);

} // namespace oncollide::tools
