#pragma once
#include <Eigen/Core>

namespace oncollide {

// Signs of orientation determinants, exact for all finite doubles: subnormal, huge, and both at once.
//
// A filter decides nearly always. With u = 2^-53, the determinant is evaluated in double on differences of
// coordinates; let P be the same sum with every product replaced by its magnitude. On the way to the result a product
// of orient3d meets 8 roundings (3 differences, product, sum of the minor, product, 2 sums), one of orient2d 4 (2
// differences, product, sum). So without underflow the error is at most 8 u (1 + 8 u) times the true P, and P as
// evaluated, with its own roundings, is at least (1 - 9 u) of that: 9 u P, and 5 u P in the plane, are bounds.
// A product that underflows errs by 2^-1075 besides. `filter_tiny`, added to each minor of P and to the bound, is
// more than enough for that: 9 u 2^-900 > 2 * 2^-1075. Overflow makes the bound infinite or not a number, so that no
// comparison with it holds. What the filter leaves open is decided in integers (wide_integer.hpp).
//
// The evaluation must not be contracted or reordered (-ffp-contract=off, no -ffast-math).
constexpr double filter_bound_2d = 5 * 0x1p-53;
constexpr double filter_bound_3d = 9 * 0x1p-53;
constexpr double filter_tiny = 0x1p-900;

/// 1 when a, b, c turn counter-clockwise, -1 when clockwise, 0 when they are on one line. Coordinates are finite.
/// Cost: about 3 ns; 0.05 to 0.2 microseconds where the filter cannot tell, 1 to 20 where the coordinates' magnitudes
/// are more than 2^200 apart.
int orient2d(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c);

/// 1 when d is on the side of plane abc to which (b - a) x (c - a) points, -1 on the other side, 0 on the plane or when
/// a, b, c are on one line. Coordinates are finite. Cost: about 6 ns; else as orient2d.
int orient3d(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d);

/// The filters alone: the sign where they are certain, else 0.
int orient2d_filter(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c);
int orient3d_filter(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                    const Eigen::Vector3d& d);

/// The exact evaluations alone.
int orient2d_exact(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c);
int orient3d_exact(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                   const Eigen::Vector3d& d);

/// True when the three points are on one line, exactly.
bool collinear(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

// Rounded results: from extended precision where that is certain to suffice, else of the exact evaluations alone.

/// The t for which p + t (q - p) is on the plane abc, within 2^-49 of its magnitude. a, b, c are not on one line; p and
/// q are not both on the plane and not strictly on one side.
double crossing_parameter(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                          const Eigen::Vector3d& p, const Eigen::Vector3d& q);
double crossing_parameter_exact(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                                const Eigen::Vector3d& p, const Eigen::Vector3d& q);

/// The same for the line ab in the plane.
double crossing_parameter(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p,
                          const Eigen::Vector2d& q);

/// (b - a) x (c - a) at unit length, each component within 2^-49; 0 when the points are on one line.
Eigen::Vector3d unit_normal(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);
Eigen::Vector3d unit_normal_exact(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

} // namespace oncollide
