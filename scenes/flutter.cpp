#include <oncollide/scenes/flutter.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <oncollide/scenes/model/surface_grid.hpp>

namespace oncollide {

namespace {

/// Nodes and weights of Gauss and Legendre's quadrature over [-1, 1], the positive half.
constexpr std::array<double, 4> node{0.18343464249564980, 0.52553240991632899, 0.79666647741362674,
                                     0.96028985649753623};
constexpr std::array<double, 4> weight{0.36268378337836198, 0.31370664587788729, 0.22238103445337447,
                                       0.10122853629037626};

} // namespace

void Flutter::check() const
{
    constexpr double largest = 1e6, unit = 1e-6;
    const auto within = [](double least, double x, double most) { return least <= x && x <= most; };
    const auto fail = [](const char* what) { throw Error(ErrorKind::bad_data, what); };
    if (!(edge.cwiseAbs().maxCoeff() <= largest) || !edge.allFinite())
        fail("edge: coordinates must be finite, and at most 1e6");
    for (const Eigen::Vector3d& direction : {along, normal})
        if (!within(1 - unit, direction.norm(), 1 + unit)) fail("along and normal must have length 1");
    if (!within(-unit, along.dot(normal), unit)) fail("along and normal must be perpendicular");
    if (!within(1 / largest, growth, largest)) fail("growth must be from 1e-6 to 1e6");
    for (const Wave& wave : waves) {
        if (!within(-largest, wave.angle, largest) || !within(-largest, wave.slant, largest) ||
            !within(-largest, wave.phase, largest))
            fail("the angle, slant and phase of a wave must be from -1e6 to 1e6");
        if (!within(1 / largest, wave.length, largest) || !within(1 / largest, wave.period, largest))
            fail("the length and period of a wave must be from 1e-6 to 1e6");
    }
}

/// The angle of the cloth to its direction at rest.
double Flutter::angle(double distance, double beside, double time) const
{
    double sum = 0;
    for (const Wave& wave : waves) {
        const double turns = distance / wave.length - time / wave.period + wave.slant * beside;
        sum += wave.angle * circle(turns + wave.phase).sine;
    }
    return sum * distance / (distance + growth);
}

void Flutter::move(const Mesh& rest, double time, std::span<Eigen::Vector3d> positions)
{
    const Eigen::Vector3d side = normal.cross(along);
    double shortest = std::numeric_limits<double>::infinity();
    for (const Wave& wave : waves) shortest = std::min(shortest, wave.length);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const Eigen::Vector3d from_edge = rest.vertices[i] - edge;
        const double distance = from_edge.dot(along), beside = from_edge.dot(side), above = from_edge.dot(normal);
        positions[i] = rest.vertices[i];
        if (!(distance > 0)) continue;
        // The integral of the direction from the edge, in steps of at most a wave and a half.
        const int steps = static_cast<int>(std::clamp(std::ceil(distance / (1.5 * shortest)), 1.0, 100.0));
        const double half = 0.5 * distance / steps;
        double x = 0, y = 0;
        for (int step = 0; step < steps; ++step)
            for (std::size_t k = 0; k < node.size(); ++k)
                for (const double sign : {-1.0, 1.0}) {
                    const double a = angle(half * (2 * step + 1 + sign * node[k]), beside, time);
                    const Circle direction = circle(a / (2 * std::numbers::pi));
                    x += half * weight[k] * direction.cosine, y += half * weight[k] * direction.sine;
                }
        const Circle end = circle(angle(distance, beside, time) / (2 * std::numbers::pi));
        x -= above * end.sine, y += above * end.cosine; // the cloth's thickness is along its normal
        positions[i] = edge + beside * side + x * along + y * normal;
    }
}

} // namespace oncollide
