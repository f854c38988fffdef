// The three scenes of Serpa and Rodrigues, "Broadmark: a testing framework for broad-phase collision detection
// algorithms", Computer Graphics Forum 2020: 30 frames per second, boxes that fill a tenth of the room.
//
// Broadmark records them from physics engines. Here boxes neither touch nor rotate. Instead each box has its own walls,
// placed such that all boxes together, pressed into any corner, fill 60 % of the space that they occupy, as a settled
// heap does. A box that reaches its floor stays there.
#include "bench/broad/box_scenes.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

constexpr double second = 30;          // frames
constexpr double weight = 9.81;        // metres per second squared
constexpr double density = 0.1;        // share of the room that boxes fill
constexpr double heap = density / 0.6; // share of the room that a settled heap takes
constexpr double fastest = 5;          // metres per second at the start
constexpr std::uint64_t cycle = 100;   // frames in which every box of the Brownian scene gets a new velocity
constexpr double gravity_period = 6.2; // seconds per revolution of gravity
constexpr double gravity_scale = 4;

/// Edges of the i-th box of the mixture: of every 80, 19 have the paper's special shapes; the others are random.
Vector3d assorted_edges(std::uint64_t i, std::uint64_t seed)
{
    constexpr double thin = 0.1, thick = 1.9;
    const std::uint64_t shape = i % 80;
    if (shape < 4) return Vector3d::Constant(0.5);
    if (shape < 8) return Vector3d::Constant(thick);
    const double bar = 8 * thick, rod = 4 * thin, plank = 3 * thick, square = 2 * thick;
    const Vector3d special[] = {{bar, rod, rod},        {bar, rod, rod},         {bar, rod, rod},
                                {rod, bar, rod},        {rod, rod, bar},         {thick, plank, thin},
                                {thick, thin, plank},   {thin, thick, 3 * thin}, {square, square, thin},
                                {square, thin, square}, {thin, square, square}};
    if (shape < 8 + std::size(special)) return special[shape - 8];
    const Vector3d drawn{u01(seed, i, 0), u01(seed, i, 1), u01(seed, i, 2)};
    return 0.803 * (Vector3d::Constant(thin) + (thick - thin) * drawn);
}

struct Particles {
    std::uint64_t seed = 0;
    std::vector<Vector3d> half, position, velocity; ///< metres, metres per frame
    std::vector<Vector3d> low, high;                ///< walls of each box

    Vector3d random_velocity(std::uint64_t i, std::uint64_t frame) const
    {
        const double z = 2 * u01(seed + frame, i, 20) - 1, turn = 2 * std::numbers::pi * u01(seed + frame, i, 21);
        const double ring = std::sqrt(1 - z * z), speed = fastest / second * std::cbrt(u01(seed + frame, i, 22));
        return speed * Vector3d{ring * std::cos(turn), ring * std::sin(turn), z};
    }
};

/// `squeeze`: the fraction of the room's side to which the boxes can be pressed together, by axis.
Particles make_particles(std::size_t count, bool assorted, const Vector3d& squeeze, std::uint64_t seed)
{
    Particles p;
    p.seed = seed;
    double volume = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
        p.half.push_back(0.5 * (assorted ? assorted_edges(i, seed) : Vector3d(Vector3d::Ones())));
        volume += 8 * p.half.back().prod();
    }
    const double side = std::cbrt(volume / density);
    for (std::uint64_t i = 0; i < count; ++i) {
        const Vector3d place{u01(seed, i, 10), u01(seed, i, 11), u01(seed, i, 12)};
        p.low.push_back(side * squeeze.cwiseProduct(place));
        p.high.push_back(p.low.back() + side * (Vector3d::Ones() - squeeze));
        p.position.push_back(side * place);
        p.velocity.push_back(p.random_velocity(i, 0));
    }
    return p;
}

/// Moves a box by one frame at `velocity`; a wall stops it (`bounce` 0) or reflects it (1).
bool move(Particles& p, std::uint32_t i, double bounce)
{
    const Vector3d before = p.position[i];
    for (int axis = 0; axis < 3; ++axis) {
        const double free = before[axis] + p.velocity[i][axis];
        p.position[i][axis] = std::clamp(free, p.low[i][axis], p.high[i][axis]);
        if (p.position[i][axis] != free) p.velocity[i][axis] *= -bounce;
    }
    return p.position[i] != before;
}

/// The direction of gravity in a frame: the x axis, rotated by a small angle per frame about an axis that itself
/// rotates.
Vector3d gravity_at(std::uint64_t frame)
{
    const double step = 2 * std::numbers::pi / (gravity_period * second);
    Vector3d about = Vector3d::UnitY(), down = Vector3d::UnitX();
    for (std::uint64_t f = 0; f < frame; ++f) {
        about = Eigen::AngleAxisd(step, Vector3d::UnitZ()) * about;
        down = Eigen::AngleAxisd(step, about) * down;
    }
    return down;
}

void step_freefall(Particles& p, std::uint32_t i)
{
    if (p.position[i].y() <= p.low[i].y())
        p.velocity[i].setZero(); // it reached the floor
    else
        p.velocity[i].y() -= weight / (second * second);
}

} // namespace

BoxScene make_broadmark_scene(std::string_view motion, bool assorted, std::size_t count, std::uint64_t seed)
{
    const double corner = std::cbrt(heap);
    Vector3d squeeze = Vector3d::Zero();
    if (motion == "freefall") squeeze.y() = heap;
    if (motion == "gravity") squeeze.setConstant(corner);
    const auto particles = std::make_shared<Particles>(make_particles(count, assorted, squeeze, seed));

    BoxScene scene;
    for (std::size_t i = 0; i < count; ++i)
        scene.boxes.push_back(box_on_grid(particles->position[i], particles->half[i]));
    scene.is_static.assign(count, 0);
    scene.next = [particles, freefall = motion == "freefall", gravity = motion == "gravity"](BoxScene& s) {
        Particles& p = *particles;
        const Vector3d pull = gravity_scale * weight / (second * second) * gravity_at(s.frame);
        s.moved.clear();
        for (std::uint32_t i = 0; i < s.boxes.size(); ++i) {
            if (freefall) step_freefall(p, i);
            if (gravity) p.velocity[i] += pull;
            if (!freefall && !gravity && i % cycle == s.frame % cycle) p.velocity[i] = p.random_velocity(i, s.frame);
            if (!move(p, i, freefall || gravity ? 0 : 1)) continue;
            s.boxes[i] = box_on_grid(p.position[i], p.half[i]);
            s.moved.push_back(i);
        }
    };
    return scene;
}

} // namespace oncollide::tools
