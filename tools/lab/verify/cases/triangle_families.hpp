// Pairs of triangles that are hard for rounded arithmetic, on grids where touching is exact.
#pragma once
#include <cctype>
#include <cmath>
#include <functional>
#include <ostream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/exact/triangle_test.hpp>

#include "verify/cases/case_numbers.hpp"

namespace oncollide {

using TwoTriangles = std::pair<TrianglePoints, TrianglePoints>;

/// Random points of a grid of 2^-20.
class GridPoints : public CaseNumbers {
public:
    using CaseNumbers::CaseNumbers;
    /// Coordinates within `most` units.
    Eigen::Vector3d point(int most)
    {
        return Eigen::Vector3d(number(-most, most), number(-most, most), number(-most, most));
    }
    TrianglePoints triangle(int most) { return {point(most), point(most), point(most)}; }
};

/// The vertices, to the last bit.
inline std::string shown(const TwoTriangles& pair)
{
    std::ostringstream out;
    out << std::hexfloat;
    for (const TrianglePoints* t : {&pair.first, &pair.second})
        for (const Eigen::Vector3d& p : *t) out << " (" << p.transpose() << ")";
    return out.str();
}

struct TriangleFamily {
    std::string name;
    std::function<TwoTriangles(GridPoints&)> make; ///< in units
};

inline std::ostream& operator<<(std::ostream& out, const TriangleFamily& family)
{
    return out << family.name;
}

/// The name in the form that gtest requires.
inline std::string test_name(const TriangleFamily& family)
{
    std::string name = family.name;
    std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
    return name;
}

/// A vertex plus multiples of a sixteenth of the triangle's edges: a point in the triangle, sometimes on its border.
/// Exact if the edges are multiples of 16.
inline Eigen::Vector3d inside(const TrianglePoints& t, GridPoints& random)
{
    const int i = random.number(0, 16), j = random.number(0, 16 - i);
    return t[0] + (i * (t[1] - t[0]) + j * (t[2] - t[0])) / 16;
}

inline TrianglePoints of_sixteenths(GridPoints& random, int most)
{
    TrianglePoints t = random.triangle(most / 16);
    for (Eigen::Vector3d& p : t) p *= 16;
    return t;
}

inline TwoTriangles edge_touching_edge(GridPoints& random)
{
    const TrianglePoints a = of_sixteenths(random, 1 << 19);
    const Eigen::Vector3d at = a[0] + random.number(0, 16) * (a[1] - a[0]) / 16, along = random.point(1 << 12);
    return {a, {at + random.number(0, 60) * along, at - random.number(0, 60) * along, random.point(1 << 20)}};
}

inline TrianglePoints sliver(GridPoints& random)
{
    const TrianglePoints t = of_sixteenths(random, 1 << 20);
    return {t[0], t[1], t[0] + random.number(-4, 20) * (t[1] - t[0]) / 16 + random.point(1)};
}

inline TwoTriangles coplanar(GridPoints& random)
{
    const Eigen::Vector3d origin = random.point(1 << 18), u = random.point(1 << 8), v = random.point(1 << 8);
    const auto corner = [&] {
        return Eigen::Vector3d(origin + random.number(-99, 99) * u + random.number(-99, 99) * v);
    };
    const auto triangle = [&] { return TrianglePoints{corner(), corner(), corner()}; };
    return {triangle(), triangle()};
}

inline TwoTriangles near_parallel(GridPoints& random)
{
    auto [a, b] = coplanar(random);
    for (Eigen::Vector3d& p : b) p += random.point(1);
    return {a, b};
}

/// A vertex on an edge, in a plane across z and rotated in it: decided by signs of two dimensions.
inline TwoTriangles corner_on_edge(GridPoints& random)
{
    TrianglePoints a = of_sixteenths(random, 1 << 20);
    const Eigen::Vector3d at = a[0] + random.number(0, 16) * (a[1] - a[0]) / 16;
    TwoTriangles pair{a, {at, random.point(1 << 20), random.point(1 << 20)}};
    const double angle = random.number(1, 1 << 20) * 0x1p-18;
    for (TrianglePoints* t : {&pair.first, &pair.second})
        for (Eigen::Vector3d& p : *t)
            p = {std::cos(angle) * p.x() - std::sin(angle) * p.y(), std::sin(angle) * p.x() + std::cos(angle) * p.y(),
                 7};
    return pair;
}

inline std::vector<TriangleFamily> triangle_families()
{
    constexpr int most = 1 << 20;
    return {
        {"random large", [](GridPoints& r) { return TwoTriangles(r.triangle(most), r.triangle(most)); }},
        {"random small", [](GridPoints& r) { return TwoTriangles(r.triangle(most / 100), r.triangle(most / 100)); }},
        {"coplanar", coplanar},
        {"shared vertex",
         [](GridPoints& r) {
             const TrianglePoints a = r.triangle(most);
             return TwoTriangles(a, {r.point(most), a[r.number(0, 2)], r.point(most)});
         }},
        {"shared edge",
         [](GridPoints& r) {
             const TrianglePoints a = r.triangle(most);
             const int k = r.number(0, 2);
             return TwoTriangles(a, {a[k], r.point(most), a[(k + 1) % 3]});
         }},
        {"vertex on face",
         [](GridPoints& r) {
             const TrianglePoints a = of_sixteenths(r, most);
             return TwoTriangles(a, {inside(a, r), r.point(most), r.point(most)});
         }},
        {"vertex 1e-6 off a face",
         [](GridPoints& r) {
             const TrianglePoints a = of_sixteenths(r, most);
             return TwoTriangles(a, {inside(a, r) + r.point(1), r.point(most), r.point(most)});
         }},
        {"edge touches edge", edge_touching_edge},
        {"slivers", [](GridPoints& r) { return TwoTriangles(sliver(r), sliver(r)); }},
        {"far from the origin",
         [](GridPoints& r) {
             TwoTriangles pair(r.triangle(1 << 10), r.triangle(1 << 10));
             for (TrianglePoints* t : {&pair.first, &pair.second})
                 for (Eigen::Vector3d& p : *t) p.array() += 0x1p40;
             return pair;
         }},
        {"near-parallel planes", near_parallel},
        {"corner on edge in a plane", corner_on_edge},
    };
}

/// Every vertex p becomes turn * p + by, rounded.
inline TwoTriangles moved(TwoTriangles pair, const Eigen::Matrix3d& turn, const Eigen::Vector3d& by)
{
    for (TrianglePoints* t : {&pair.first, &pair.second})
        for (Eigen::Vector3d& p : *t) p = turn * p + by;
    return pair;
}

} // namespace oncollide
