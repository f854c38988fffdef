#pragma once
#include <cstdint>

#include "truth/tally.hpp"
#include "verify/cases/near_families.hpp"

namespace oncollide::tools {

/// `count` pairs of triangles of a family, as two meshes. Compares all lower and upper bounds with the exact distance:
/// of the kernels, decide() with and without clearance and error, distance(), near_features(), clear_until; and a live
/// World with a new one after moves by less and by more than the remembered gap. The pairs do not depend on the number
/// of threads. Cost: about 0.3 ms per pair.
Tally try_bounds(const NearFamily& family, std::uint64_t count, int threads);

} // namespace oncollide::tools
