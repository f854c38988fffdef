// Integers of the oracles. Only the oracles include this: Boost takes long to compile.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include <boost/multiprecision/cpp_int.hpp>

#include <oncollide/narrowphase/exact/triangle_test.hpp>

#include "truth/exact_point.hpp"

namespace oncollide::oracle {

/// Signed integers of N times 64 bits and a sign: another project's, so the oracle shares no arithmetic with the
/// library.
template <int N>
using Int = boost::multiprecision::number<
    boost::multiprecision::cpp_int_backend<64 * N, 64 * N, boost::multiprecision::signed_magnitude,
                                           boost::multiprecision::unchecked, void>,
    boost::multiprecision::et_off>;

template <int N>
using Point = PointOf<Int<N>>;

/// A double as integer times 2^lowest.
template <class Integer>
Integer integer(double x, int lowest)
{
    int exponent = 0;
    const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
    const int shift = exponent - 53 - lowest;
    return shift >= 0 ? Integer(mantissa) << shift : Integer(mantissa >> -shift);
}

/// Range of the binary digits of a set of coordinates.
struct Digits {
    int lowest = 2000, highest = -2000;

    void take(double x)
    {
        if (x == 0) return;
        int exponent = 0;
        auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
        highest = std::max(highest, exponent);
        lowest = std::min(lowest, exponent - 53 + std::countr_zero(static_cast<std::uint64_t>(mantissa)));
    }
    template <std::size_t N>
    void take(const std::array<Eigen::Vector3d, N>& points)
    {
        for (const Eigen::Vector3d& v : points)
            for (double x : v) take(x);
    }
    int count() const { return std::max(highest - lowest + 1, 0); }
};

} // namespace oncollide::oracle
