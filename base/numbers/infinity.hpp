#pragma once

#include <limits>

namespace oncollide {

inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr float float_infinity = std::numeric_limits<float>::infinity();

} // namespace oncollide
