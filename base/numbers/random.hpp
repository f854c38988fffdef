#pragma once
#include <cstdint>

namespace oncollide {

/// splitmix64: the next state of the generator, which is also its output.
inline std::uint64_t splitmix(std::uint64_t z)
{
    z += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

/// A uniform number in [0, 1) for (seed, index, k), the same on every machine. Scenes are generated from these numbers.
double u01(std::uint64_t seed, std::uint64_t index, std::uint64_t k);

} // namespace oncollide
