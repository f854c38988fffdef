#pragma once
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

/// Why no two bodies of the scene are compared: there are fewer than two, all are static, or groups and layers keep all
/// apart. Empty if two are. Excluded pairs are not looked at.
std::string why_nothing_is_compared(const Scene& scene);

} // namespace oncollide::tools
