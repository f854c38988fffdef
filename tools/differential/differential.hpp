#pragma once
#include <functional>
#include <optional>
#include <string>

#include "differential/drawn_scene.hpp"

namespace oncollide::tools {

/// Plays the scene and holds every pair of every frame against the truth about convex sets (convex_truth.hpp), and the
/// run against others that must give the same: on another number of threads, without coherence, with another broad
/// phase, with the bodies in reverse. Returns what is wrong first; empty: nothing.
/// Cost: about 2 ms.
std::string fault_in(const DrawnScene& drawn);

/// The first of `count` seeds from `first` on whose scene has a fault. Calls done() for each, one at a time.
std::optional<std::uint64_t> first_faulty_seed(std::uint64_t first, std::uint64_t count, int threads,
                                               const std::function<void()>& done);

/// The smallest scene and plainest settings found by leaving things out, one after the other, that are still faulty.
DrawnScene shrunk(DrawnScene drawn, const std::function<bool(const DrawnScene&)>& faulty);

/// The options of `oncollide run` that stand for the settings.
std::string options_of(const Settings& settings);

} // namespace oncollide::tools
