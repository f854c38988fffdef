#include "verify/trials/graze_trial.hpp"

#include <cmath>
#include <memory>

#include <fmt/format.h>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/scene.hpp>

#include "verify/cases/body_case.hpp"
#include "verify/cases/case_numbers.hpp"
#include "verify/cases/placed_body.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;

/// A sweep, and when the bodies meet for certain. Times are of the truth; infinite: never.
struct GrazeCase {
    GeometryData a, b;
    RigidMotion motion_a{}, motion_b{};
    std::string name{}; ///< kinds
    SweepOptions options{};
    double size = 1;               ///< of the bodies and of their coordinates
    double gap = 0;                ///< of the graze
    double hidden = 0;             ///< gaps up to this may be hidden by rounding
    double grazes_from = INFINITY; ///< the bodies are `gap` apart, or meet for an instant, from this time on
    double meets = INFINITY;       ///< they get into each other
    double speed = 1;              ///< of that, at least, metres per unit of time; the end of the motion is far
};

double power(CaseNumbers& draw, int least, int most)
{
    return std::ldexp(1, draw.number(least, most));
}

/// A body whose lowest and foremost points are `s` from its centre.
GeometryData slider(int kind, double s)
{
    switch (kind) {
    case 0:
        return Shape(Box{{s, s, s}});
    case 1:
        return make_box_mesh({s, s, s});
    case 2:
        return Shape(Sphere{s});
    case 3:
        return Shape(Ellipsoid{{s, 0.5 * s, s}});
    case 4:
        return Shape(Capsule{0.5 * s, s});
    default:
        return make_box_mesh({s, s, s}, 3);
    }
}
constexpr int slider_kinds = 6;
/// The capsule's axis is z: its foremost points are half as far.
double front_of(int kind, double s)
{
    return kind == 4 ? 0.5 * s : s;
}

Mesh floor_with_wall(double s, double wall)
{
    return joined(shifted(make_box_mesh({16 * s, 16 * s, s}), {0, 0, -s}),
                  shifted(make_box_mesh({s, 4 * s, 4 * s}), {wall + s, 0, 4 * s}));
}

/// Along the floor: into a wall, or to the end of the motion.
GrazeCase slide(CaseNumbers& draw)
{
    const double s = power(draw, -20, 20), gap = draw.number(0, 7) ? s * power(draw, -50, -8) : 0;
    const int kind = draw.number(0, slider_kinds - 1), below = draw.number(0, 3);
    GrazeCase c{.a = slider(kind, s),
                .b = Shape(HalfSpace{}),
                .size = 32 * s,
                .gap = gap,
                .hidden = 0x1p-39 * 32 * s,
                .grazes_from = 0};
    const double from = -8 * s, wall = 4 * s, to = 6 * s;
    c.motion_a = RigidMotion(at(from, 0, s + gap), at(to, 0, s + gap));
    if (below == 0) {
        c.b = floor_with_wall(s, wall);
        c.speed = to - from, c.meets = (wall - front_of(kind, s) - from) / c.speed;
    } else if (below == 1) {
        c.b = Shape(Box{{16 * s, 16 * s, s}}), c.motion_b = RigidMotion(at(0, 0, -s));
    } else if (below == 2) {
        c.b = shifted(make_box_mesh({16 * s, 16 * s, s}), {0, 0, -s});
    }
    c.name = fmt::format("slider {} on {}", kind, below);
    return c;
}

/// Straight through a plate that is up to 2^23 times as large.
GrazeCase fall(CaseNumbers& draw)
{
    const double s = power(draw, -6, 2), plate = s * power(draw, 2, 23);
    const int kind = draw.number(0, slider_kinds - 1);
    GrazeCase c{.a = slider(kind, s), .b = Shape(Box{{plate, plate, s}}), .size = plate};
    if (draw.one_in(2)) c.b = make_box_mesh({plate, plate, s});
    const double x = s * draw.real(0, 1), y = s * draw.real(0, 1);
    c.motion_a = RigidMotion(at(x, y, 8 * s), at(x, y, -8 * s)), c.speed = 16 * s;
    c.meets = (8 * s - 2 * s) / c.speed;
    // The tolerances are as small as doubles allow.
    const double least = std::max(1e-12, 0x1p-32 * plate);
    c.options.gap_tolerance = c.options.time_tolerance = std::max(least, draw.one_in(2) ? 1e-4 : 1e-9);
    return c;
}

/// A ball along x past another one, whose top is `gap` below its lowest point.
GrazeCase pass(CaseNumbers& draw)
{
    const double s = power(draw, -20, 20), gap = draw.number(0, 7) ? s * power(draw, -50, -8) : 0;
    const double sign = draw.sign(), far = 2 * s + sign * gap;
    GrazeCase c{
        .a = Shape(Sphere{s}), .b = Shape(Sphere{s}), .size = 8 * s, .gap = gap, .hidden = 0x1p-32 * s, .speed = 8 * s};
    c.motion_a = RigidMotion(at(-4 * s, 0, far), at(4 * s, 0, far));
    // The exact time is where x^2 = (2 s)^2 - far^2.
    const double square = sign < 0 ? (2 * s - far) * (2 * s + far) : 0, half = std::sqrt(square);
    c.grazes_from = 0.5 - half / c.speed;
    if (sign < 0 && gap > 0x1p-36 * s) c.meets = c.grazes_from, c.gap = 0;
    return c;
}

std::string text_of(const SweepResult& r)
{
    return fmt::format("{} {:.17g} to {:.17g}, grazes until {:.17g}, gap {:g}", name_of(r.verdict), r.clear_until,
                       r.contact_by, r.grazes_until, r.gap);
}

std::string fault_of(const GrazeCase& c, const SweepResult& r)
{
    const SweepOptions& o = c.options;
    const double tiny = 0x1p-40, pressed = o.stop == SweepStop::press ? o.gap_tolerance : 0;
    const double late = o.time_tolerance + 2 * (pressed + o.gap_tolerance) / c.speed;
    const bool grazes = std::isfinite(c.grazes_from) && c.gap <= c.hidden;
    const double first = std::min(c.meets, grazes ? c.grazes_from : INFINITY);
    if (r.clear_until > c.meets + tiny) return "a collision is missed";
    if (!(r.gap <= o.gap_tolerance * (1 + 1e-3)) && std::isfinite(r.contact_by))
        return "the gap is above its tolerance";
    if (r.verdict == Verdict::undecided) return "undecided";
    if (r.clear_until < std::min(first, 1.0) - late - tiny) return "the bound stops before a graze or a contact";
    const bool sunk = c.size * tiny > o.gap_tolerance;
    if (r.verdict == Verdict::separate)
        return std::isfinite(c.meets) && !(pressed > 0 && c.size < 64 * pressed) ? "a collision is missed" : "";
    if (r.verdict == Verdict::within) {
        if (!grazes && !std::isfinite(c.meets)) return "a certain gap is left open";
        if (!r.normal.isZero(0)) return "a normal without a meaning";
        if (o.stop == SweepStop::touch || pressed > 0) return "";
        return std::isfinite(c.meets) && !sunk ? "a certain contact is not found" : "";
    }
    if (r.contact_by - r.grazes_until > o.time_tolerance + tiny) return "the bracket is too wide";
    const bool met = r.contact_by >= c.meets - tiny, touched = grazes && r.contact_by >= c.grazes_from - late - tiny;
    if (!met && !(touched && pressed == 0)) return "a contact is invented";
    if (met && !grazes && r.grazes_until > c.meets + late) return "the contact is late";
    return {};
}

} // namespace

std::string graze_fault(std::uint64_t seed, GrazeTally& tally)
{
    CaseNumbers draw(seed);
    const int scene = draw.number(0, 3);
    GrazeCase c = scene < 2 ? slide(draw) : scene == 2 ? fall(draw) : pass(draw);
    constexpr SweepStop stops[] = {SweepStop::contact, SweepStop::contact, SweepStop::touch, SweepStop::press};
    c.options.stop = stops[draw.number(0, 3)];
    // Tolerances are of the size, where they are not the case.
    if (scene != 2) c.options.gap_tolerance = std::max(1e-12, 0x1p-12 * c.size);
    World world;
    const MovingModel a{add_model(world, c.a), c.motion_a}, b{add_model(world, c.b), c.motion_b};
    const SweepResult found = world.pairs().sweep(a, b, c.options), swapped = world.pairs().sweep(b, a, c.options);
    ++tally.sweeps;
    ++(found.verdict == Verdict::colliding  ? tally.contacts
       : found.verdict == Verdict::within   ? tally.grazes
       : found.verdict == Verdict::separate ? tally.clear
                                            : tally.open);
    std::string fault = fault_of(c, found);
    if (fault.empty() && !fault_of(c, swapped).empty()) fault = "swapped: " + fault_of(c, swapped);
    if (fault.empty() && found.verdict != swapped.verdict) fault = "another verdict with the bodies swapped";
    if (fault.empty()) return {};
    ++tally.faults;
    return fmt::format("{}: scene {} ({}), size {:g}, gap {:g}, stop {}: {}; swapped {}; meets at {:.17g}", fault,
                       scene, c.name, c.size, c.gap, name_of(c.options.stop), text_of(found), text_of(swapped),
                       c.meets);
}

GrazeTally& GrazeTally::operator+=(const GrazeTally& o)
{
    sweeps += o.sweeps, contacts += o.contacts, grazes += o.grazes, clear += o.clear, open += o.open;
    faults += o.faults, first += o.first;
    return *this;
}

GrazeTally try_grazes(std::uint64_t first, std::uint64_t count, int threads, const std::function<void()>& done)
{
    return sum_of_seeds<GrazeTally>(
        first, count, threads,
        [](std::uint64_t seed, GrazeTally& tally) { tally.first.take(seed, graze_fault(seed, tally)); }, done);
}

} // namespace oncollide::tools
