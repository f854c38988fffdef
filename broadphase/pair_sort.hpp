#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide {

/// Sorts pairs by (a, b): radix sort, least significant digit first, over the bits that body numbers below `bodies`
/// use. `scratch` keeps its capacity between calls. Cost: O(pairs).
void sort_pairs(std::vector<BodyPair>& pairs, std::vector<BodyPair>& scratch, std::size_t bodies);

} // namespace oncollide
