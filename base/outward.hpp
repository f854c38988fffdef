// Rounding boxes outward to float.
#pragma once
#include <cmath>
#include <limits>

namespace oncollide {

// One float step outward is at most 2^-23 of the magnitude, and a double rounds to float within half of that.
inline float below(double x)
{
    const float f = static_cast<float>(x);
    return f - std::abs(f) * 0x1p-23f - std::numeric_limits<float>::min();
}
inline float above(double x)
{
    return -below(-x);
}

} // namespace oncollide
