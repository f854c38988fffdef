#include "verify/trials/hard_trials.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/samples/generators.hpp>

#include "truth/exact_oracle.hpp"
#include "verify/cases/terrain_shape.hpp"
#include "verify/oracle/exact_distance.hpp"
#include "verify/trials/pair_trial.hpp"
#include "verify/trials/seeds.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

enum class TerrainFamily { balls, capsules, boxes, triangles, half_spaces, terrains, off };

/// A body near the terrain, and the truth about both.
struct Other {
    PlacedBody body;
    bool meet;
    long double distance = 0; ///< for spheres and capsules; 0 if they meet
};

/// All rotations by quarter turns that take z to one of the axes.
Isometry3d quarter_turn(std::int64_t axis, bool back)
{
    Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
    for (int i = 0; i < 3; ++i) turn((i + 1 + int(axis)) % 3, i) = 1;
    if (back) turn = turn * Eigen::Vector3d(1, -1, -1).asDiagonal();
    return Isometry3d(turn);
}

bool meet(const PlaceTriangle& s, const PlaceTriangle& t)
{
    for (std::size_t i = 0; i < 3; ++i) {
        const auto [low, high] = std::minmax({s[0][i], s[1][i], s[2][i]});
        const auto [least, most] = std::minmax({t[0][i], t[1][i], t[2][i]});
        if (high < least || most < low) return false;
    }
    return oracle::contact(points_of(s), points_of(t)) != TriangleContact::separate;
}

bool meet(const std::vector<PlaceTriangle>& all, const std::vector<PlaceTriangle>& others)
{
    return std::ranges::any_of(all, [&](const PlaceTriangle& s) {
        return std::ranges::any_of(others, [&](const PlaceTriangle& t) { return meet(s, t); });
    });
}

/// The faces of a box.
std::vector<PlaceTriangle> faces_of(const Place& low, const Place& high)
{
    const Mesh box = make_box_mesh({1, 1, 1});
    std::vector<PlaceTriangle> faces;
    for (const Triangle& t : box.triangles)
        for (PlaceTriangle& face = faces.emplace_back(); const std::size_t k : {0, 1, 2})
            for (std::size_t i = 0; i < 3; ++i) face[k][i] = box.vertices[t[k]][int(i)] > 0 ? high[i] : low[i];
    return faces;
}

class TerrainTrial {
public:
    using enum TerrainFamily;
    TerrainTrial(TerrainFamily family, std::uint64_t number)
        : draw_(number * 8 + std::uint64_t(family)), family_(family)
    {
    }

    void run(const std::string& what, Tally& tally)
    {
        const TerrainShape shape(draw_, family_ == off);
        const auto form = family_ == boxes ? static_cast<BoxForm>(draw_.number(0, 3)) : BoxForm::shape;
        const bool long_one = family_ == capsules || (family_ == off && draw_.one_in(2));
        draw_frame(form == BoxForm::cell ? draw_.number(-27, 6) : draw_.number(-43, 16)); // cells: 1e-6 to 1e6 m
        const Other other = family_ == balls || family_ == capsules || family_ == off ? ball(shape, long_one)
                            : family_ == boxes                                        ? box(shape, form)
                            : family_ == triangles                                    ? triangle(shape)
                            : family_ == half_spaces                                  ? half_space(shape)
                                                                                      : terrain(shape);
        const PlacedBody ground = placed(shape, Isometry3d::Identity(), {});
        const bool swapped = draw_.one_in(2);
        const PlacedBody &a = swapped ? other.body : ground, &b = swapped ? ground : other.body;
        PairTruth truth = truth_if(other.meet);
        if (family_ == off) {
            truth.uncertain = true;
            if (!other.meet) truth.distance.low = truth.distance.high = double(other.distance);
        }
        try_pair(a, b, truth, what, tally);
    }

private:
    void draw_frame(std::int64_t exponent)
    {
        frame_.unit = std::ldexp(1.0, int(exponent)), frame_.offset.setZero();
        constexpr std::int64_t least = 18;                                   // larger than all coordinates
        const std::int64_t most = std::min<std::int64_t>(50, 26 - exponent); // 1e8 m; whole units are doubles
        if (most < least) return;
        for (int i = 0; i < 3; ++i)
            if (draw_.one_in(2)) frame_.offset[i] = 0.75 * std::ldexp(frame_.unit, int(draw_.number(least, most)));
    }
    /// Moves the point by at most one unit of the grid.
    void push(Place& p)
    {
        if (!draw_.one_in(3)) p[std::size_t(draw_.number(0, 2))] += draw_.sign();
    }

    PlacedBody placed(const TerrainShape& shape, const Isometry3d& turn, const Place& at_place)
    {
        Place origin{};
        if (draw_.one_in(2))
            for (std::int64_t& x : origin) x = draw_.number(-(1 << 20), 1 << 20);
        const Isometry3d pose = frame_.at(at_place) * turn * Eigen::Translation3d(-frame_.point(origin));
        if (family_ == off) {
            const double off_by = draw_.one_in(2) ? double(draw_.number(1, 64)) : 0;
            return {shape.made(frame_.unit, origin, draw_.one_in(4) ? 2 : 1, off_by), pose};
        }
        static constexpr int bytes[] = {0, 1, 2, 4, 8};
        Terrain made = shape.made(frame_.unit, origin, bytes[draw_.number(0, 4)]);
        if (made.error() > 0) made = shape.made(frame_.unit, origin, 8);
        return {std::move(made), pose};
    }

    struct Ball {
        Place centre;
        std::int64_t radius = 0, half = 0;
        std::size_t axis = 0;
    };
    /// A sphere, or a capsule along an axis.
    Ball draw_ball(const TerrainShape& shape, bool long_one)
    {
        Ball ball;
        Place away = draw_.away(ball.radius);
        if (shape.normal[2] && draw_.one_in(2)) { // on the plane
            const auto length = static_cast<std::int64_t>(vector_of(shape.normal).norm());
            const std::int64_t times = draw_.number(1, (1 << 12) / length), side = draw_.sign();
            ball.radius = times * length;
            for (std::size_t i = 0; i < 3; ++i) away[i] = side * times * shape.normal[i];
        }
        ball.centre = shape.feature(draw_);
        for (std::size_t i = 0; i < 3; ++i) ball.centre[i] += away[i];
        push(ball.centre);
        ball.axis = std::size_t(draw_.number(0, 2));
        ball.half = long_one ? draw_.number(1, TerrainShape::width) : 0;
        if (long_one && draw_.one_in(2)) // its end touches
            ball.centre[ball.axis] += away[ball.axis] < 0 ? -ball.half : ball.half;
        return ball;
    }
    /// The distance of the ball's axis from the ground.
    static oracle::ExactDistance distance(const Ball& ball, std::span<const TrianglePoints> ground)
    {
        const Vector3d half = double(ball.half) * Vector3d::Unit(int(ball.axis)), from = vector_of(ball.centre) - half,
                       to = vector_of(ball.centre) + half;
        return oracle::least_distance({from, to, to}, ground);
    }
    /// A body that nearly touches, if one is found soon.
    Other ball(const TerrainShape& shape, bool long_one)
    {
        std::vector<TrianglePoints> ground;
        for (const PlaceTriangle& t : shape.triangles()) ground.push_back(points_of(t));
        const std::int64_t near = family_ == off ? draw_.number(2, 500) : 2;
        Ball found = draw_ball(shape, long_one);
        oracle::ExactDistance apart = distance(found, ground);
        for (int tries = 0; tries < 20 && apart.compare(double(std::max<std::int64_t>(found.radius - near, 0))) <= 0;
             ++tries)
            found = draw_ball(shape, long_one), apart = distance(found, ground);
        double metres = frame_.unit * double(found.radius);
        const int order = apart.compare(double(found.radius));
        bool meet = order <= 0;
        if (family_ != off && order == 0 && draw_.one_in(2)) { // tangent: the last bit decides
            meet = draw_.one_in(2);
            metres = std::nextafter(metres, meet ? 2 * metres : 0);
        }
        const long double gap = meet ? 0 : frame_.unit * (apart.value() - static_cast<long double>(found.radius));
        const Isometry3d pose = frame_.at(found.centre) * quarter_turn(std::int64_t(found.axis), draw_.one_in(2));
        if (!long_one) return {{Shape(Sphere{metres}), pose}, meet, gap};
        return {{Shape(Capsule{metres, 2 * frame_.unit * double(found.half)}), pose}, meet, gap};
    }

    /// Moves the triangles by some units in some direction, so that bodies that only touch come apart.
    std::vector<PlaceTriangle> moved_aside(std::vector<PlaceTriangle> all)
    {
        const auto axis = std::size_t(draw_.number(0, 2));
        const int by = 3 * draw_.sign();
        for (PlaceTriangle& t : all)
            for (Place& p : t) p[axis] += by;
        return all;
    }

    Other box(const TerrainShape& shape, BoxForm form)
    {
        Place low, high;
        const std::vector<PlaceTriangle> ground = shape.triangles();
        for (int tries = 0; tries < 6; ++tries) {
            low = shape.feature(draw_);
            const std::int64_t side = TerrainShape::width / 4 * draw_.number(1, 4);
            for (std::size_t i = 0; i < 3; ++i) {
                const std::int64_t size = form == BoxForm::cell ? side : TerrainShape::width / 4 * draw_.number(1, 4);
                low[i] -= size / 2 * draw_.number(0, 2), high[i] = size;
            }
            push(low);
            for (std::size_t i = 0; i < 3; ++i) high[i] += low[i];
            if (!meet(ground, moved_aside(faces_of(low, high)))) break;
        }
        bool touch = meet(ground, faces_of(low, high));
        for (const PlaceTriangle& t : ground) // enclosed: a mesh has no inside
            touch |= form != BoxForm::mesh && t[0][0] >= low[0] && t[0][0] <= high[0] && t[0][1] >= low[1] &&
                     t[0][1] <= high[1] && t[0][2] >= low[2] && t[0][2] <= high[2];
        return {make_box(form, frame_, low, high), touch};
    }

    Other triangle(const TerrainShape& shape)
    {
        PlaceTriangle t;
        for (int tries = 0; tries < 6; ++tries) {
            for (Place& p : t) {
                p = shape.feature(draw_);
                for (std::int64_t& x : p) x += TerrainShape::width / 4 * draw_.number(-2, 2);
            }
            push(t[std::size_t(draw_.number(0, 2))]);
            if (!meet(shape.triangles(), moved_aside({t}))) break;
        }
        return {make_triangle(frame_, t), meet(shape.triangles(), {t})};
    }

    Other half_space(const TerrainShape& shape)
    {
        const auto axis = std::size_t(draw_.number(0, 2));
        const bool back = draw_.one_in(2); // the half-space is above or below the plane's coordinate
        Place on = shape.feature(draw_);
        for (const PlaceTriangle& t : shape.triangles()) // the terrain's extent on that axis
            for (const Place& p : t) on[axis] = back ? std::max(on[axis], p[axis]) : std::min(on[axis], p[axis]);
        push(on);
        bool touch = false;
        for (const PlaceTriangle& t : shape.triangles())
            for (const Place& p : t) touch |= back ? p[axis] >= on[axis] : p[axis] <= on[axis];
        return {{Shape(HalfSpace{}), frame_.at(on) * quarter_turn(std::int64_t(axis), back)}, touch};
    }

    Other terrain(const TerrainShape& shape)
    {
        const TerrainShape second(draw_);
        const Isometry3d turn = quarter_turn(draw_.number(0, 2), draw_.one_in(2));
        // A feature of one terrain on a feature of the other.
        Place by = shape.feature(draw_);
        const auto rotated = [&](const Place& p) {
            const Vector3d q = turn * Vector3d(double(p[0]), double(p[1]), double(p[2]));
            return Place{std::int64_t(q.x()), std::int64_t(q.y()), std::int64_t(q.z())};
        };
        const Place from = rotated(second.feature(draw_));
        for (std::size_t i = 0; i < 3; ++i) by[i] -= from[i];
        if (draw_.one_in(2)) by[2] += TerrainShape::width * draw_.number(0, 2);
        push(by);
        std::vector<PlaceTriangle> theirs = second.triangles();
        for (PlaceTriangle& t : theirs)
            for (Place& p : t) {
                p = rotated(p);
                for (std::size_t i = 0; i < 3; ++i) p[i] += by[i];
            }
        return {placed(second, turn, by), meet(shape.triangles(), theirs)};
    }

    TerrainDraw draw_;
    TerrainFamily family_;
    GridFrame frame_{};
};

} // namespace

Tally try_terrain(const std::string& family, std::uint64_t count, int threads)
{
    const auto which = static_cast<TerrainFamily>(std::ranges::find(terrain_families, family) - terrain_families);
    return try_many(family, count, threads, [&](std::uint64_t number, Tally& tally) {
        TerrainTrial(which, number).run(fmt::format("case {} of '{}'", number, family), tally);
    });
}

} // namespace oncollide::tools
