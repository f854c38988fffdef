#include <oncollide/scenes/files/hdf5/hdf5_checksum.hpp>

#include <algorithm>
#include <bit>
#include <cstring>

namespace oncollide {

namespace {

struct Words {
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

std::uint32_t hdf5_checksum(std::string_view bytes)
{
    const std::uint32_t start = 0xdeadbeef + static_cast<std::uint32_t>(bytes.size());
    Words words{start, start, start};
    for (; bytes.size() > 12; bytes.remove_prefix(12)) words.add(bytes.data()), words.mix();
    if (bytes.empty()) return words.c;
    char last[12] = {};
    std::memcpy(last, bytes.data(), bytes.size());
    words.add(last), words.finish();
    return words.c;
}

std::uint32_t fletcher32(std::string_view bytes)
{
    const auto folded = [](std::uint32_t sum) { return (sum & 0xffff) + (sum >> 16); };
    std::uint32_t first = 0, second = 0;
    const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])); };
    for (std::size_t i = 0, words = bytes.size() / 2; i < words;) {
        constexpr std::size_t without_overflow = 360;
        for (const std::size_t end = std::min(words, i + without_overflow); i < end; ++i)
            first += byte(2 * i) << 8 | byte(2 * i + 1), second += first;
        first = folded(first), second = folded(second);
    }
    if (bytes.size() % 2) first += byte(bytes.size() - 1) << 8, second += first;
    first = folded(folded(first)), second = folded(folded(second));
    return second << 16 | first;
}

} // namespace oncollide
