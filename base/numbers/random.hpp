#pragma once
#include <cstdint>

namespace oncollide {

/// splitmix64: the next state of the generator, which is also its output.
std::uint64_t splitmix(std::uint64_t z);

/// A uniform number in [0, 1) for (seed, index, k), the same on every machine. Scenes are generated from these numbers.
double u01(std::uint64_t seed, std::uint64_t index, std::uint64_t k);

} // namespace oncollide
