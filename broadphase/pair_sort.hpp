#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide {

/// Sorts pairs by (a, b): distributes them to buckets of consecutive a, then counting-sorts each bucket. `scratch`
/// keeps its capacity between calls. Cost: O(pairs) if bodies are in a few pairs each, O(pairs log pairs) at worst.
void sort_pairs(std::vector<BodyPair>& pairs, std::vector<BodyPair>& scratch, std::size_t bodies, int threads = 1);

} // namespace oncollide
