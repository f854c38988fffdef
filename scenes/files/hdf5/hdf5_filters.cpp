#include <oncollide/scenes/files/hdf5/hdf5_filters.hpp>

#include <algorithm>
#include <limits>

#include <zlib.h>

namespace oncollide {

namespace {

constexpr std::uint64_t fletcher_bytes = 4; // bytes of Fletcher's checksum

[[noreturn]] void damaged_chunk()
{
    throw Hdf5Fault{"the file is damaged or cut off: a chunk cannot be unpacked"};
}

void inflate_all(const std::string& packed, std::string& out)
{
    constexpr std::size_t most = std::numeric_limits<uInt>::max();
    z_stream stream{};
    if (packed.size() > most || out.size() > most || inflateInit(&stream) != Z_OK) damaged_chunk();
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data()), stream.avail_out = static_cast<uInt>(out.size());
    const int result = inflate(&stream, Z_FINISH);
    inflateEnd(&stream);
    if (result != Z_STREAM_END || stream.avail_out != 0) damaged_chunk();
}

template <std::size_t bytes>
void join_bytes(const std::string& planes, std::string& out)
{
    const std::size_t count = planes.size() / bytes;
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t k = 0; k < bytes; ++k) out[bytes * i + k] = planes[k * count + i];
}

/// The file has the first bytes of all numbers, then the second bytes, and so on.
void unshuffle(std::size_t bytes, const std::string& planes, std::string& out)
{
    out = planes; // bytes after the last whole number keep their places
    switch (bytes) {
    case 0:
        damaged_chunk();
    case 1:
        return;
    case 2:
        return join_bytes<2>(planes, out);
    case 4:
        return join_bytes<4>(planes, out);
    case 8:
        return join_bytes<8>(planes, out);
    default:
        break;
    }
    const std::size_t count = planes.size() / bytes;
    for (std::size_t k = 0; k < bytes && count > 0; ++k)
        for (std::size_t i = 0; i < count; ++i) out[bytes * i + k] = planes[k * count + i];
}

/// Fletcher's checksum with sums of 16 bits, over big-endian words.
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

void check_fletcher(std::string& bytes)
{
    if (bytes.size() < fletcher_bytes) damaged_chunk();
    const std::size_t size = bytes.size() - fletcher_bytes;
    std::uint32_t stored = 0;
    for (std::size_t i = fletcher_bytes; i-- > 0;) stored = stored << 8 | static_cast<unsigned char>(bytes[size + i]);
    bytes.resize(size);
    if (fletcher32(bytes) != stored) throw Hdf5Fault{"the file is damaged: wrong checksum of a chunk"};
}

} // namespace

void undo_hdf5_filters(std::span<const Hdf5Filter> filters, std::uint32_t skipped, std::string& stored,
                       std::string& out, std::uint64_t size)
{
    for (std::size_t i = filters.size(); i-- > 0;) {
        if (skipped >> i & 1) continue;
        if (filters[i].kind == Hdf5Filter::fletcher) {
            check_fletcher(stored);
            continue;
        }
        if (filters[i].kind == Hdf5Filter::deflate) {
            out.resize(size);
            for (std::size_t k = 0; k < i; ++k)
                if (filters[k].kind == Hdf5Filter::fletcher && !(skipped >> k & 1)) out.resize(size + fletcher_bytes);
            inflate_all(stored, out);
        } else {
            unshuffle(filters[i].value, stored, out);
        }
        stored.swap(out);
    }
    if (stored.size() != size) damaged_chunk();
    stored.swap(out);
}

} // namespace oncollide
