// Integers of a fixed width, and doubles written as such integers times a common power of two: the exact arithmetic
// behind the predicates. Every finite double is an integer times 2^-1074, so no coordinate is out of range.
#pragma once
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <type_traits>

namespace oncollide {

__extension__ typedef unsigned __int128 Uint128;

/// Two's complement, 64 N bits, least significant limb first. Overflow is not checked: the caller chooses N.
template <int N>
struct WideInteger {
    std::array<std::uint64_t, N> limb{};

    bool negative() const { return limb[N - 1] >> 63; }
    int sign() const
    {
        if (negative()) return -1;
        for (std::uint64_t l : limb)
            if (l) return 1;
        return 0;
    }
    WideInteger operator-() const { return WideInteger{} - *this; }
    WideInteger magnitude() const { return negative() ? -*this : *this; }

    friend WideInteger operator+(const WideInteger& a, const WideInteger& b)
    {
        WideInteger sum;
        std::uint64_t carry = 0;
        for (int i = 0; i < N; ++i) {
            const Uint128 s = Uint128(a.limb[i]) + b.limb[i] + carry;
            sum.limb[i] = static_cast<std::uint64_t>(s), carry = static_cast<std::uint64_t>(s >> 64);
        }
        return sum;
    }
    friend WideInteger operator-(const WideInteger& a, const WideInteger& b)
    {
        WideInteger difference;
        std::uint64_t borrow = 0;
        for (int i = 0; i < N; ++i) {
            const Uint128 d = Uint128(a.limb[i]) - b.limb[i] - borrow;
            difference.limb[i] = static_cast<std::uint64_t>(d), borrow = static_cast<std::uint64_t>(d >> 64) & 1;
        }
        return difference;
    }
};

/// The full product. Cost: A B multiplications of limbs.
template <int A, int B>
WideInteger<A + B> operator*(const WideInteger<A>& a, const WideInteger<B>& b)
{
    const WideInteger<A> p = a.magnitude();
    const WideInteger<B> q = b.magnitude();
    WideInteger<A + B> product;
    for (int i = 0; i < A; ++i) {
        std::uint64_t carry = 0;
        for (int j = 0; j < B; ++j) {
            const Uint128 t = Uint128(p.limb[i]) * q.limb[j] + product.limb[i + j] + carry;
            product.limb[i + j] = static_cast<std::uint64_t>(t), carry = static_cast<std::uint64_t>(t >> 64);
        }
        product.limb[i + B] = carry;
    }
    return a.negative() != b.negative() ? -product : product;
}

/// Bits of the magnitude; 0 for 0.
template <int N>
int bit_length(const WideInteger<N>& a)
{
    const WideInteger<N> m = a.magnitude();
    for (int i = N - 1; i >= 0; --i)
        if (m.limb[i]) return 64 * i + std::bit_width(m.limb[i]);
    return 0;
}

/// a / 2^bits for |a| < 2^bits, with a relative error of at most 2^-51 or an absolute one of at most 2^-1073.
template <int N>
double scaled_down(const WideInteger<N>& a, int bits)
{
    const WideInteger<N> m = a.magnitude();
    double value = 0;
    for (int i = 0; i < N; ++i) value += std::ldexp(static_cast<double>(m.limb[i]), 64 * i - bits);
    return a.negative() ? -value : value;
}

/// Numbers on this grid are integers times 2^exponent, below 2^(exponent + bits) in magnitude.
struct BinaryGrid {
    int exponent = 0, bits = 0;
};

/// A finite double as mantissa * 2^exponent with an odd mantissa; 0 as 0.
struct Decoded {
    std::uint64_t mantissa;
    int exponent;
    bool negative;

    explicit Decoded(double x)
    {
        const auto pattern = std::bit_cast<std::uint64_t>(x);
        const std::uint64_t fraction = pattern & ((std::uint64_t(1) << 52) - 1);
        const int field = static_cast<int>(pattern >> 52 & 0x7ff);
        mantissa = field ? fraction | std::uint64_t(1) << 52 : fraction;
        const int zeros = mantissa ? std::countr_zero(mantissa) : 0;
        mantissa >>= zeros;
        exponent = (field ? field : 1) - 1075 + zeros;
        negative = pattern >> 63;
    }
};

/// The coarsest grid that holds all `numbers`.
inline BinaryGrid grid_of(std::span<const double> numbers)
{
    int low = 2000, high = -2000;
    for (double x : numbers) {
        const Decoded d(x);
        if (!d.mantissa) continue;
        low = d.exponent < low ? d.exponent : low;
        const int top = d.exponent + std::bit_width(d.mantissa);
        high = top > high ? top : high;
    }
    return low > high ? BinaryGrid{} : BinaryGrid{low, high - low};
}

/// x / 2^grid.exponent as an integer.
template <int N>
WideInteger<N> on_grid(double x, const BinaryGrid& grid)
{
    const Decoded d(x);
    WideInteger<N> value;
    if (!d.mantissa) return value;
    const int shift = d.exponent - grid.exponent, i = shift / 64, rest = shift % 64;
    value.limb[i] = d.mantissa << rest;
    if (rest && i + 1 < N) value.limb[i + 1] = d.mantissa >> (64 - rest);
    return d.negative ? -value : value;
}

/// Calls f(std::integral_constant<int, N>) with N large enough that differences of numbers on the grid fit in N limbs,
/// sums of two products of two differences in 2 N, sums of six products of three differences in 3 N, sums of
/// twelve products of four in 4 N, and squares of the sums of six in 6 N: a difference is below 2^(bits + 1), a sum of
/// six such products below 2^(3 bits + 6).
template <class F>
auto with_limbs(const BinaryGrid& grid, F f)
{
    const int needed = grid.bits + 3;
    if (needed <= 64) return f(std::integral_constant<int, 1>{});
    if (needed <= 128) return f(std::integral_constant<int, 2>{});
    if (needed <= 256) return f(std::integral_constant<int, 4>{});
    if (needed <= 1024) return f(std::integral_constant<int, 16>{});
    return f(std::integral_constant<int, 33>{}); // 2,098 bits span all doubles
}

} // namespace oncollide
