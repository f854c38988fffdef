#include <oncollide/base/numbers/random.hpp>

namespace oncollide {

std::uint64_t splitmix(std::uint64_t z)
{
    z += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

double u01(std::uint64_t seed, std::uint64_t index, std::uint64_t k)
{
    return static_cast<double>(splitmix(splitmix(splitmix(seed) + index) + k) >> 11) * 0x1p-53;
}

} // namespace oncollide
