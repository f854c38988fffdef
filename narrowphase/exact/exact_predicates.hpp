#pragma once
#include <Eigen/Core>

namespace oncollide {

// Signs of orientation determinants, exact for all finite doubles: subnormal, huge, and both at once.
//
// A filter decides nearly always. With u = 2^-53, the determinant is evaluated in double on differences of coordinates;
// let P be the same sum with every product replaced by its magnitude. A product of orient3d passes through 8 roundings
// (3 differences, product, sum of the minor, product, 2 sums), a product of orient2d through 4 (2 differences, product,
// sum). Without underflow the error is then at most 8 u (1 + 8 u) times the true P, and the evaluated P, with its own
// roundings, is at least (1 - 9 u) times the true P: 9 u P, and 5 u P in the plane, are bounds. A product that
// underflows errs by 2^-1075 in addition. `filter_tiny`, added to each minor of P and to the bound, is more than enough
// for that: 9 u 2^-900 > 2 * 2^-1075. Overflow makes the bound infinite or NaN, so no comparison with it holds.
// Integers decide the remaining cases (wide_integer.hpp).
//
// The evaluation must not be contracted or reordered (-ffp-contract=off, no -ffast-math).
constexpr double filter_bound_2d = 5 * 0x1p-53;
constexpr double filter_bound_3d = 9 * 0x1p-53;
constexpr double filter_tiny = 0x1p-900;

/// 1 if a, b, c are in counter-clockwise order, -1 if clockwise, 0 if they are on one line. Coordinates are finite.
/// Cost: about 3 ns; if the filter cannot decide 0.05 to 0.2 microseconds, or 1 to 20 if the coordinates' magnitudes
/// are more than 2^200 apart.
int orient2d(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c);

/// 1 if d is on the side of plane abc to which (b - a) x (c - a) points, -1 on the other side, 0 on the plane or if a,
/// b, c are on one line. Coordinates are finite. Cost: about 6 ns; else as orient2d.
int orient3d(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d);

/// The filters alone: the sign if it is certain, else 0.
int orient2d_filter(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c);
int orient3d_filter(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                    const Eigen::Vector3d& d);

/// The exact evaluations alone.
int orient2d_exact(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c);
int orient3d_exact(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                   const Eigen::Vector3d& d);

/// True if the three points are on one line, exactly.
bool collinear(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

// Rounded results: from extended precision if that is certain to suffice, else from the exact evaluations.

/// The t for which p + t (q - p) is on the plane abc, within 2^-49 of its magnitude. a, b, c must not be on one line; p
/// and q must not both be on the plane, nor strictly on the same side.
double crossing_parameter(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                          const Eigen::Vector3d& p, const Eigen::Vector3d& q);
double crossing_parameter_exact(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                                const Eigen::Vector3d& p, const Eigen::Vector3d& q);

/// The same for the line ab in two dimensions.
double crossing_parameter(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p,
                          const Eigen::Vector2d& q);

/// (b - a) x (c - a) at unit length, each component within 2^-49; 0 if the points are on one line.
Eigen::Vector3d unit_normal(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);
Eigen::Vector3d unit_normal_exact(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

} // namespace oncollide
