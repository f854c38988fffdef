#include "verify/trials/hard_trials.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/samples/generators.hpp>

#include "truth/exact_oracle.hpp"
#include "verify/cases/case_numbers.hpp"
#include "verify/trials/pair_trial.hpp"
#include "verify/trials/seeds.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;
constexpr std::int64_t cube_side = 1 << 20; ///< side of the cube, whose lowest corner is the origin

/// The body that touches the cube: all points within `radius` of a segment along z, or a triangle.
struct Toucher {
    Place centre{};
    std::int64_t radius = 0, half = 0;
    std::array<Place, 3> corners{};
    bool triangle = false;
};

std::int64_t outside(std::int64_t low, std::int64_t high)
{
    return std::max<std::int64_t>({low - cube_side, -high, 0});
}

bool ball_meets(const Toucher& t)
{
    std::int64_t square = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::int64_t reach = i == 2 ? t.half : 0, d = outside(t.centre[i] - reach, t.centre[i] + reach);
        square += d * d;
    }
    return square <= t.radius * t.radius;
}

bool triangle_meets(const Toucher& t)
{
    const TrianglePoints corners = points_of(t.corners);
    const Vector3d half = Vector3d::Constant(cube_side / 2.0);
    const Mesh cube = make_box_mesh(half);
    for (const Triangle& face : cube.triangles) {
        const auto corner = [&](int k) -> Vector3d { return cube.vertices[face[std::size_t(k)]] + half; };
        if (oracle::contact({corner(0), corner(1), corner(2)}, corners) != TriangleContact::separate) return true;
    }
    return std::ranges::all_of(t.corners[0], [](std::int64_t x) { return x >= 0 && x <= cube_side; });
}

class TangentDraw : public CaseNumbers {
public:
    using CaseNumbers::CaseNumbers;
    /// A Pythagorean vector with this many coordinates that are not 0, and its length `radius`.
    Place away(int coordinates, std::int64_t& radius)
    {
        static constexpr std::int64_t triples[][3] = {{3, 4, 5}, {5, 12, 13}, {8, 15, 17}, {20, 21, 29}};
        static constexpr std::int64_t quadruples[][4] = {{1, 2, 2, 3}, {2, 3, 6, 7}, {1, 4, 8, 9}, {2, 6, 9, 11}};
        const std::int64_t times = number(1, 1 << 17), which = number(0, 3);
        if (coordinates == 1) return radius = times, Place{times, 0, 0};
        if (coordinates == 2) {
            const auto& t = triples[which];
            return radius = times * t[2], Place{times * t[0], times * t[1], 0};
        }
        const auto& q = quadruples[which];
        return radius = times * q[3], Place{times * q[0], times * q[1], times * q[2]};
    }
    Toucher ball(int coordinates, bool along_edge)
    {
        Toucher t;
        const Place away = this->away(along_edge ? 2 : coordinates, t.radius);
        const int turn = along_edge ? 0 : int(number(0, 2));
        for (int i = 0; i < 3; ++i) {
            const std::int64_t d = away[(i + turn) % 3];
            const bool high = number(0, 1);
            t.centre[i] = d == 0 ? number(1, cube_side - 1) : high ? cube_side + d : -d;
        }
        if (along_edge) t.half = number(1, 2 * cube_side);
        t.centre[number(0, 2)] += number(-1, 1); // at most a unit off
        return t;
    }
    Toucher triangle()
    {
        Toucher t;
        t.triangle = true;
        // Corners on a coarse grid around the cube touch faces, edges and corners; then one may be moved by a unit.
        for (Place& p : t.corners)
            for (std::int64_t& x : p) x = number(-2, 4) * (cube_side / 2);
        t.corners[number(0, 2)][number(0, 2)] += number(-1, 1);
        return t;
    }
};

PlacedBody toucher_of(const Toucher& t, const GridFrame& frame)
{
    if (t.triangle) return make_triangle(frame, t.corners);
    if (t.half == 0) return {Shape(Sphere{frame.unit * double(t.radius)}), frame.at(t.centre)};
    return {Shape(Capsule{frame.unit * double(t.radius), 2 * frame.unit * double(t.half)}), frame.at(t.centre)};
}

void try_one(const std::string& family, std::uint64_t number, Tally& tally)
{
    const auto f = std::ranges::find(tangent_families, family) - tangent_families;
    TangentDraw draw(number * 8 + std::uint64_t(f));
    const Toucher t = f == 4 ? draw.triangle() : draw.ball(int(f) + 1, f == 3);
    const bool meet = t.triangle ? triangle_meets(t) : ball_meets(t);
    const BoxForm form = f == 4 ? BoxForm::cell : static_cast<BoxForm>(draw.number(0, 3));
    const int exponent = form == BoxForm::cell ? draw.number(-39, -1) : draw.number(-50, 10); // cells: 1e-6 to 1e6 m
    GridFrame frame{std::ldexp(1.0, exponent), {}};
    for (int i = 0; i < 3; ++i) // bodies are within 1e15 m
        frame.offset[i] =
            draw.number(0, 1) * 0.75 * std::ldexp(1.0, exponent + 20 + draw.number(0, std::min(26, 28 - exponent)));
    const PlacedBody cube = make_box(form, frame, {}, {cube_side, cube_side, cube_side}), other = toucher_of(t, frame);
    const bool swapped = draw.number(0, 1);
    const PlacedBody &a = swapped ? other : cube, &b = swapped ? cube : other;
    try_pair(a, b, truth_if(meet), fmt::format("case {} of '{}'", number, family), tally);
}

} // namespace

Tally try_tangent(const std::string& family, std::uint64_t count, int threads)
{
    return try_many(family, count, threads,
                    [&](std::uint64_t number, Tally& tally) { try_one(family, number, tally); });
}

} // namespace oncollide::tools
