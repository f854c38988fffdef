// Numbers of all types and byte orders.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include <oncollide/scenes/files/hdf5/hdf5_dataset.hpp>

namespace oncollide {

namespace {

/// IEEE 754 with 16 bits.
struct Half {
    std::uint16_t bits;

    explicit operator double() const
    {
        const int exponent = bits >> 10 & 31;
        const double mantissa = bits & 1023, sign = bits >> 15 ? -1 : 1;
        if (exponent == 31)
            return mantissa > 0 ? std::numeric_limits<double>::quiet_NaN()
                                : sign * std::numeric_limits<double>::infinity();
        return sign * (exponent > 0 ? std::ldexp(1024 + mantissa, exponent - 25) : std::ldexp(mantissa, -24));
    }
};

template <class In>
In load(const char* from, bool swapped)
{
    char bytes[sizeof(In)];
    std::memcpy(bytes, from, sizeof bytes);
    if (swapped) std::reverse(std::begin(bytes), std::end(bytes));
    return std::bit_cast<In>(bytes);
}

template <class Out, class In>
Out converted(In value)
{
    if constexpr (std::is_same_v<In, std::uint64_t> && std::is_same_v<Out, std::int64_t>)
        return static_cast<Out>(std::min(value, static_cast<In>(std::numeric_limits<Out>::max())));
    return static_cast<Out>(value);
}

template <class In, bool swapped, class Out>
void convert(const Hdf5Piece& piece, Out* out)
{
    for (std::uint64_t r = 0; r < piece.rows; ++r) {
        const char* const from = piece.from + r * piece.row_bytes;
        Out* const to = out + piece.to + r * piece.to_row;
        if (piece.value_bytes == sizeof(In))
            for (std::uint64_t c = 0; c < piece.columns; ++c)
                to[c] = converted<Out>(load<In>(from + c * sizeof(In), swapped));
        else
            std::fill_n(to, piece.columns, converted<Out>(load<In>(from, swapped)));
    }
}

template <class In, class Out>
void read_as(const Hdf5Dataset& dataset, std::span<const std::uint64_t> start, std::span<const std::uint64_t> count,
             Out* out)
{
    if (dataset.type().is_big_endian)
        dataset.read(start, count, [&](const Hdf5Piece& piece) { convert<In, true>(piece, out); });
    else
        dataset.read(start, count, [&](const Hdf5Piece& piece) { convert<In, false>(piece, out); });
}

template <class Out>
void read_any(const Hdf5Dataset& dataset, std::span<const std::uint64_t> start, std::span<const std::uint64_t> count,
              Out* out)
{
    const Hdf5Type& type = dataset.type();
    if (type.kind == Hdf5Type::Kind::real) {
        if constexpr (std::is_same_v<Out, double>) {
            if (type.size == 2) return read_as<Half>(dataset, start, count, out);
            if (type.size == 4) return read_as<float>(dataset, start, count, out);
            if (type.size == 8) return read_as<double>(dataset, start, count, out);
        }
    } else if (type.kind == Hdf5Type::Kind::whole) {
        switch (2 * type.size + type.is_signed) {
        case 2:
            return read_as<std::uint8_t>(dataset, start, count, out);
        case 3:
            return read_as<std::int8_t>(dataset, start, count, out);
        case 4:
            return read_as<std::uint16_t>(dataset, start, count, out);
        case 5:
            return read_as<std::int16_t>(dataset, start, count, out);
        case 8:
            return read_as<std::uint32_t>(dataset, start, count, out);
        case 9:
            return read_as<std::int32_t>(dataset, start, count, out);
        case 16:
            return read_as<std::uint64_t>(dataset, start, count, out);
        case 17:
            return read_as<std::int64_t>(dataset, start, count, out);
        default:
            break;
        }
    }
    throw Hdf5Fault{hdf5_other_type};
}

} // namespace

void read_hdf5_numbers(const Hdf5Dataset& dataset, std::span<const std::uint64_t> start,
                       std::span<const std::uint64_t> count, double* out)
{
    read_any(dataset, start, count, out);
}

void read_hdf5_numbers(const Hdf5Dataset& dataset, std::span<const std::uint64_t> start,
                       std::span<const std::uint64_t> count, std::int64_t* out)
{
    read_any(dataset, start, count, out);
}

} // namespace oncollide
