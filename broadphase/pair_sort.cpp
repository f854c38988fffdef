#include <oncollide/broadphase/pair_sort.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

namespace oncollide {

namespace {

constexpr int digit_bits = 11;

template <class Key>
void sort_by(std::vector<BodyPair>& pairs, std::vector<BodyPair>& scratch, int key_bits, Key key)
{
    for (int shift = 0; shift < key_bits; shift += digit_bits) {
        std::array<std::uint32_t, (1u << digit_bits)> starts{};
        const auto digit = [&](BodyPair p) { return key(p) >> shift & ((1u << digit_bits) - 1); };
        for (BodyPair p : pairs) ++starts[digit(p)];
        std::uint32_t sum = 0;
        for (std::uint32_t& start : starts) sum += std::exchange(start, sum);
        for (BodyPair p : pairs) scratch[starts[digit(p)]++] = p;
        pairs.swap(scratch);
    }
}

} // namespace

void sort_pairs(std::vector<BodyPair>& pairs, std::vector<BodyPair>& scratch, std::size_t bodies)
{
    if (pairs.size() < 512) {
        std::sort(pairs.begin(), pairs.end());
        return;
    }
    scratch.resize(pairs.size());
    const int key_bits = std::bit_width(bodies);
    sort_by(pairs, scratch, key_bits, [](BodyPair p) { return p.b; });
    sort_by(pairs, scratch, key_bits, [](BodyPair p) { return p.a; });
}

} // namespace oncollide
