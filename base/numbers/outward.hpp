// Rounding boxes outward to float.
#pragma once
#include <cmath>
#include <limits>

namespace oncollide {

// Conversion to float rounds by at most half a step; the step outward, at most 2^-23 of the magnitude, exceeds that.
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
