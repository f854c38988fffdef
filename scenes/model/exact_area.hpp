#pragma once
#include <cmath>
#include <limits>

#include <Eigen/Core>

namespace oncollide {

/// Whether a, b and c are collinear, decided exactly (if the coordinates of the triangle span fewer than 400 powers of
/// two). Private to scenes.
bool are_in_line(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// True if the triangle is a segment or a point: are_in_line() with a fast path for clear cases. Private to scenes.
inline bool has_zero_area(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c)
{
    // Each difference has an error of at most half an ulp; each product, and their difference, adds another. Eight half
    // ulps of the two products' magnitudes exceed that; the smallest normal number covers underflow.
    constexpr double ulps = 8 * std::numeric_limits<double>::epsilon(), tiny = std::numeric_limits<double>::min();
    for (int k = 2; k >= 0; --k) { // z first: most flat surfaces are perpendicular to z
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double left = (b[i] - a[i]) * (c[j] - a[j]), right = (b[j] - a[j]) * (c[i] - a[i]);
        if (std::abs(left - right) > ulps * (std::abs(left) + std::abs(right)) + 4 * tiny) return false;
    }
    return are_in_line(a, b, c);
}

} // namespace oncollide
