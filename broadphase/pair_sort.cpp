#include <oncollide/broadphase/pair_sort.hpp>

#include <algorithm>
#include <array>
#include <utility>

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/parallel.hpp>

namespace oncollide {

namespace {

/// Few enough that each bucket's write position stays in the cache.
constexpr std::size_t most_buckets = 512;

/// Sorts [first, last) by b; all pairs have the same a.
void sort_by_b(BodyPair* first, BodyPair* last)
{
    if (last - first > 32) return std::sort(first, last);
    for (BodyPair* i = first + 1; i < last; ++i) {
        const BodyPair pair = *i;
        BodyPair* at = i;
        for (; at > first && pair.b < at[-1].b; --at) *at = at[-1];
        *at = pair;
    }
}

/// Sorts a bucket, whose `a` are in [low, low + range), from `from` to `to`.
void sort_bucket(std::span<const BodyPair> from, BodyPair* to, std::size_t low, std::size_t range)
{
    if (from.size() * 4 < range) {
        std::copy(from.begin(), from.end(), to);
        return std::sort(to, to + from.size());
    }
    constexpr std::size_t usual = 4096; // two million bodies
    std::array<std::uint32_t, usual> on_stack;
    std::vector<std::uint32_t> many(range > usual ? range : 0);
    const std::span<std::uint32_t> ends = range > usual ? std::span(many) : std::span(on_stack).first(range);
    std::ranges::fill(ends, 0);
    for (BodyPair p : from) ++ends[p.a - low];
    std::uint32_t sum = 0;
    for (std::uint32_t& end : ends) sum += std::exchange(end, sum);
    for (BodyPair p : from) to[ends[p.a - low]++] = p; // after this loop, ends[] holds ends
    std::uint32_t begin = 0;
    for (std::uint32_t end : ends) {
        if (end - begin > 1) sort_by_b(to + begin, to + end);
        begin = end;
    }
}

} // namespace

void sort_pairs(std::vector<BodyPair>& pairs, std::vector<BodyPair>& scratch, std::size_t bodies, int threads)
{
    ONCOLLIDE_ASSERT(threads >= 1);
    ONCOLLIDE_ASSERT(std::ranges::all_of(pairs, [&](BodyPair pair) { return pair.a < bodies; }));
    if (pairs.size() < 512) {
        std::sort(pairs.begin(), pairs.end());
        return;
    }
    int shift = 0;
    while ((bodies >> shift) >= most_buckets) ++shift;
    // Each thread distributes a share of the pairs; in a bucket, pairs follow in the order of shares.
    constexpr std::size_t most_shares = 16;
    const std::size_t shares = std::clamp<std::size_t>(static_cast<std::size_t>(threads), 1, most_shares);
    std::array<std::array<std::uint32_t, most_buckets>, most_shares> next;
    const auto share_of = [&](std::size_t s) {
        const std::size_t begin = pairs.size() * s / shares, end = pairs.size() * (s + 1) / shares;
        return std::span<const BodyPair>(pairs).subspan(begin, end - begin);
    };
    parallel_chunks(shares, 1, threads, [&](std::size_t first, std::size_t last, int) {
        for (std::size_t s = first; s < last; ++s) {
            next[s].fill(0);
            for (BodyPair p : share_of(s)) ++next[s][p.a >> shift];
        }
    });
    std::array<std::uint32_t, most_buckets + 1> begins{};
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < most_buckets; ++i) {
        begins[i] = sum;
        for (std::size_t s = 0; s < shares; ++s) sum += std::exchange(next[s][i], sum);
    }
    begins[most_buckets] = sum;
    scratch.resize(pairs.size());
    parallel_chunks(shares, 1, threads, [&](std::size_t first, std::size_t last, int) {
        for (std::size_t s = first; s < last; ++s)
            for (BodyPair p : share_of(s)) scratch[next[s][p.a >> shift]++] = p;
    });
    parallel_chunks(most_buckets, 16, threads, [&](std::size_t first, std::size_t last, int) {
        for (std::size_t i = first; i < last; ++i)
            if (begins[i] < begins[i + 1])
                sort_bucket(std::span(scratch).subspan(begins[i], begins[i + 1] - begins[i]), pairs.data() + begins[i],
                            i << shift, std::size_t{1} << shift);
    });
    ONCOLLIDE_ASSERT(std::ranges::is_sorted(pairs));
}

} // namespace oncollide
