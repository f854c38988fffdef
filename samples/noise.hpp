#pragma once
#include <cstdint>

namespace oncollide {

/// Six octaves of value noise, each half as high and half as wide, in [0, 1). x and y in [0, 1]. Private to the
/// samples.
double fractal_noise(double x, double y, std::uint64_t seed);

} // namespace oncollide
