#include <oncollide/base/numbers/random.hpp>

namespace oncollide {

double u01(std::uint64_t seed, std::uint64_t index, std::uint64_t k)
{
    return static_cast<double>(splitmix(splitmix(splitmix(seed) + index) + k) >> 11) * 0x1p-53;
}

} // namespace oncollide
