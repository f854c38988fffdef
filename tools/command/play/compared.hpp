#pragma once
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

/// Returns why no two bodies of the scene are compared: there are fewer than two, all are static, or groups and layers
/// keep all of them apart. Empty if two bodies are compared. Excluded pairs are ignored.
std::string why_nothing_is_compared(const Scene& scene);

} // namespace oncollide::tools
