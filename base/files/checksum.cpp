#include <oncollide/base/files/checksum.hpp>

#include <array>
#include <bit>
#include <cstring>

namespace oncollide {

namespace {

constexpr std::uint64_t primes[] = {0x9e3779b185ebca87, 0xc2b2ae3d27d4eb4f, 0x165667b19e3779f9, 0x85ebca77c2b2ae63,
                                    0x27d4eb2f165667c5};

template <class Word>
Word word_at(const char* at)
{
    Word word;
    std::memcpy(&word, at, sizeof word);
    return word;
}

std::uint64_t stirred(std::uint64_t lane, std::uint64_t word)
{
    return std::rotl(lane + word * primes[1], 31) * primes[0];
}

} // namespace

std::uint64_t checksum(std::string_view bytes)
{
    const char *at = bytes.data(), *const end = at + bytes.size();
    std::uint64_t hash = primes[4];
    if (bytes.size() >= 32) {
        std::array<std::uint64_t, 4> lanes{primes[0] + primes[1], primes[1], 0, 0 - primes[0]};
        for (; end - at >= 32; at += 32)
            for (std::size_t k = 0; k < 4; ++k) lanes[k] = stirred(lanes[k], word_at<std::uint64_t>(at + 8 * k));
        hash = std::rotl(lanes[0], 1) + std::rotl(lanes[1], 7) + std::rotl(lanes[2], 12) + std::rotl(lanes[3], 18);
        for (const std::uint64_t lane : lanes) hash = (hash ^ stirred(0, lane)) * primes[0] + primes[3];
    }
    hash += bytes.size();
    for (; end - at >= 8; at += 8)
        hash = std::rotl(hash ^ stirred(0, word_at<std::uint64_t>(at)), 27) * primes[0] + primes[3];
    if (end - at >= 4) {
        hash = std::rotl(hash ^ word_at<std::uint32_t>(at) * primes[0], 23) * primes[1] + primes[2];
        at += 4;
    }
    for (; at < end; ++at) hash = std::rotl(hash ^ static_cast<unsigned char>(*at) * primes[4], 11) * primes[0];
    hash = (hash ^ hash >> 33) * primes[1];
    hash = (hash ^ hash >> 29) * primes[2];
    return hash ^ hash >> 32;
}

namespace {

/// The state of lookup3.
struct Lookup3 {
    std::uint32_t a, b, c;

    void add(const char* twelve)
    {
        std::uint32_t words[3];
        std::memcpy(words, twelve, sizeof words);
        a += words[0], b += words[1], c += words[2];
    }
    void mix()
    {
        a -= c, a ^= std::rotl(c, 4), c += b;
        b -= a, b ^= std::rotl(a, 6), a += c;
        c -= b, c ^= std::rotl(b, 8), b += a;
        a -= c, a ^= std::rotl(c, 16), c += b;
        b -= a, b ^= std::rotl(a, 19), a += c;
        c -= b, c ^= std::rotl(b, 4), b += a;
    }
    void finish()
    {
        c ^= b, c -= std::rotl(b, 14);
        a ^= c, a -= std::rotl(c, 11);
        b ^= a, b -= std::rotl(a, 25);
        c ^= b, c -= std::rotl(b, 16);
        a ^= c, a -= std::rotl(c, 4);
        b ^= a, b -= std::rotl(a, 14);
        c ^= b, c -= std::rotl(b, 24);
    }
};

} // namespace

std::uint32_t lookup3(std::string_view bytes)
{
    const std::uint32_t start = 0xdeadbeef + static_cast<std::uint32_t>(bytes.size());
    Lookup3 words{start, start, start};
    for (; bytes.size() > 12; bytes.remove_prefix(12)) words.add(bytes.data()), words.mix();
    if (bytes.empty()) return words.c;
    char last[12] = {};
    std::memcpy(last, bytes.data(), bytes.size());
    words.add(last), words.finish();
    return words.c;
}

} // namespace oncollide
