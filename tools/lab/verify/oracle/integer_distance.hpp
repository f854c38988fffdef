#pragma once
#include <array>
#include <compare>
#include <cstdint>

namespace oncollide::tools {

// __int128 is not ISO C++.
__extension__ typedef __int128 Wide;

/// A point in units of a grid.
using Place = std::array<std::int64_t, 3>;
using PlaceTriangle = std::array<Place, 3>;

/// The square of a length, as a fraction with a positive denominator.
struct SquareLength {
    Wide numerator, denominator;

    std::strong_ordering compare(std::int64_t length) const
    {
        return numerator <=> Wide(length) * length * denominator;
    }
    bool operator<(const SquareLength& other) const;
    long double length() const;
};

/// The exact squared distance of a segment from a triangle, by cases on faces, edges and ends; the segment's ends may
/// be equal. Coordinates up to 2^16, so that products fit. Shares no code with the library.
SquareLength square_distance(const Place& from, const Place& to, const PlaceTriangle& triangle);

} // namespace oncollide::tools
