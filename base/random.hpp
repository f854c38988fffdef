#pragma once
#include <cstdint>

namespace oncollide {

/// splitmix64: the next state of a generator, which is its number too.
std::uint64_t splitmix(std::uint64_t z);

/// The uniform number in [0, 1) for (seed, index, k), the same on every machine: what all scenes are generated from.
double u01(std::uint64_t seed, std::uint64_t index, std::uint64_t k);

} // namespace oncollide
