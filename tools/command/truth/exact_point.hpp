#pragma once
#include <array>

#include <Eigen/Core>

namespace oncollide::oracle {

/// A point or a vector of numbers of any type, for the oracles: no code of the library computes with it.
template <class Number>
struct PointOf : std::array<Number, 3> {
    friend PointOf operator-(const PointOf& a, const PointOf& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
    friend PointOf operator+(const PointOf& a, const PointOf& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
    friend PointOf operator*(const Number& s, const PointOf& p) { return {s * p[0], s * p[1], s * p[2]}; }
    friend Number dot(const PointOf& a, const PointOf& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
    friend PointOf cross(const PointOf& a, const PointOf& b)
    {
        return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    }
};

/// `Number` must hold every double.
template <class Number>
PointOf<Number> point_of(const Eigen::Vector3d& p)
{
    return {Number(p.x()), Number(p.y()), Number(p.z())};
}

} // namespace oncollide::oracle
