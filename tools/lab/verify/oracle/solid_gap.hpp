#pragma once
#include "verify/oracle/solid_truth.hpp"

namespace oncollide::oracle {

/// The distance of two solids: 0 where they meet.
struct SolidGap {
    long double lower = 0, upper = 0;           ///< bounds, apart from rounding
    long double core_lower = 0, core_upper = 0; ///< the same of the cores
    LongVector toward = LongVector::Zero();     ///< unit, from a to b, where the cores are apart: across the gap
};

/// Finds the distance of a, and of b moved by `shift`. GJK: nearest points of growing simplices, each solved by trying
/// all of its faces.
SolidGap gap_of(const SolidTruth& a, const SolidTruth& b, const LongVector& shift = LongVector::Zero());
SolidGap gap_to(const SolidTruth& a, const LongVector& point);

/// How far b must move along a unit vector until a plane across it separates the two; negative: they are apart. A
/// half-space has a width only along its own normal, for which any direction is taken here.
long double width_along(const SolidTruth& a, const SolidTruth& b, const LongVector& unit);

struct LeastWidth {
    long double width;
    LongVector along;
};
/// The least width that was found: exact if one is a half-space or a sphere, both have flat cores, or the cores are
/// apart. Otherwise the best of a sample of directions, refined; the truth is at most as large.
/// @param hint  a direction that is tried, too
LeastWidth least_width(const SolidTruth& a, const SolidTruth& b, const SolidGap& gap, const LongVector& hint);

} // namespace oncollide::oracle
