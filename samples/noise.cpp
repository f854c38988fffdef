#include <oncollide/samples/noise.hpp>

#include <cmath>

#include <oncollide/base/numbers/random.hpp>

namespace oncollide {

namespace {

/// Value noise in [0, 1): random values at integer points, interpolated smoothly.
double value_noise(double x, double y, std::uint64_t seed)
{
    const double fx = std::floor(x), fy = std::floor(y), tx = x - fx, ty = y - fy;
    const double sx = tx * tx * (3 - 2 * tx), sy = ty * ty * (3 - 2 * ty);
    const auto ix = static_cast<std::uint64_t>(fx), iy = static_cast<std::uint64_t>(fy);
    const double low = (1 - sx) * u01(seed, ix, iy) + sx * u01(seed, ix + 1, iy);
    const double high = (1 - sx) * u01(seed, ix, iy + 1) + sx * u01(seed, ix + 1, iy + 1);
    return (1 - sy) * low + sy * high;
}

} // namespace

double fractal_noise(double x, double y, std::uint64_t seed)
{
    double sum = 0, weights = 0, weight = 1, frequency = 4;
    for (std::uint64_t octave = 0; octave < 6; ++octave, weight *= 0.5, frequency *= 2) {
        sum += weight * value_noise(frequency * x, frequency * y, seed + octave);
        weights += weight;
    }
    return sum / weights;
}

} // namespace oncollide
