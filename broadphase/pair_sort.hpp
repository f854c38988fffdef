#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide {

/// Sorts pairs by (a, b): dealt into buckets of consecutive a, then each bucket by counting. `scratch` keeps its
/// capacity between calls. Cost: O(pairs) for bodies in a few pairs each, O(pairs log pairs) at worst.
void sort_pairs(std::vector<BodyPair>& pairs, std::vector<BodyPair>& scratch, std::size_t bodies, int threads = 1);

} // namespace oncollide
