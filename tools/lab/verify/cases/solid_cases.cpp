// Cases that are hard only for solids: bodies wholly inside others, cavities, parts inside others, meshes inside out,
// and a tiny body just inside or outside. Most of them are apart as surfaces.
#include <cmath>

#include <fmt/format.h>

#include <oncollide/samples/generators.hpp>

#include "verify/cases/body_case.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

Mesh cube(double half)
{
    return make_box_mesh(Vector3d::Constant(half));
}

/// Adds cases of `family` with both truths known.
struct SolidFamily {
    std::vector<BodyCase>& cases;
    const char* name;

    void operator()(std::string what, const Mesh& a, const Mesh& b, const Eigen::Isometry3d& pose, bool meet,
                    bool solids_meet, const Eigen::Isometry3d& pose_a = at(0, 0, 0)) const
    {
        cases.push_back({name, std::move(what), a, b, pose_a, {pose}, meet, meet || solids_meet});
    }
};

/// Grains at a face, an edge and a corner of a box, off by one unit in the last place of its coordinates.
void grains(std::vector<BodyCase>& cases)
{
    const SolidFamily add{cases, "just inside or outside"};
    const Mesh box = cube(1), inside_out = flipped(box);
    for (const double half : {0x1p-40, 0x1p-52}) {
        const Mesh grain = cube(half);
        for (const auto& [what, x, y, z] : {std::tuple("a face", 1., 0.25, 0.125), std::tuple("an edge", 1., 1., 0.125),
                                            std::tuple("a corner", 1., 1., 1.)}) {
            const Vector3d place(x, y, z);
            const auto off = [&](double by) { // moves the coordinates that are on the boundary
                return Vector3d(place.array() + (place.array() == 1).cast<double>() * by);
            };
            const auto name = [&, what = what](const char* how) {
                return fmt::format("{} by 2^{}, {}", what, std::log2(half), how);
            };
            const double ulp = 0x1p-52;
            add(name("inside"), box, shifted(grain, off(-half - ulp)), at(0, 0, 0), false, true);
            add(name("touching within"), box, shifted(grain, off(-half)), at(0, 0, 0), true, true);
            add(name("across"), box, shifted(grain, off(0)), at(0, 0, 0), true, true);
            add(name("touching without"), box, shifted(grain, off(half)), at(0, 0, 0), true, true);
            add(name("outside"), box, shifted(grain, off(half + ulp)), at(0, 0, 0), false, false);
            add(name("in a box inside out"), inside_out, shifted(grain, off(-half - ulp)), at(0, 0, 0), false, true);
        }
    }
}

/// Bodies from which rays in all simple directions hit edges and vertices.
void enclosed(std::vector<BodyCase>& cases)
{
    const SolidFamily add{cases, "enclosed"};
    const Mesh box = cube(1), sphere = make_sphere_mesh(1, 128), torus = make_torus_mesh(1, 0.3, 240);
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 120), grain = cube(0x1p-10);
    add("at the centre of a box", box, cube(0.25), at(0, 0, 0), false, true);
    add("a box that holds the first", cube(0.25), box, at(0, 0, 0), false, true);
    add("corner towards corner", box, cube(0.25), at(0.5, 0.5, 0.5), false, true);
    add("at the centre of a sphere", sphere, grain, at(0, 0, 0), false, true);
    add("under the pole of a sphere", sphere, grain, at(0, 0, 0.875), false, true);
    add("over the pole of a sphere", sphere, grain, at(0, 0, 1.125), false, false);
    add("in the hole of a ring", torus, grain, at(0, 0, 0), false, false);
    add("in the tube of a ring", torus, grain, at(1, 0, 0), false, true);
    add("beside the tube of a ring", torus, grain, at(0.5, 0, 0), false, false);
    add("a box inside out in a sphere", sphere, flipped(cube(0.25)), at(0.125, 0, 0), false, true);
    add("a box in a sphere inside out", flipped(sphere), cube(0.25), at(0.125, 0, 0), false, true);
    add("a knot turned in a sphere", scaled(sphere, 4), knot, at({0.5, 0, 0.25}, turn_by(1, {1, 2, 3})), false, true);
    add("a box in a terrain's box", make_terrain_mesh(2, 0.4, 8, 3), grain, at(0.1, 0.1, -5), false, false);
    add("an open surface in a box", cube(4), make_terrain_mesh(2, 0.4, 8, 3), at(0.1, 0.1, 0.2), false, true);
    add("touching from within at a face", box, cube(0.25), at(0.75, 0.125, 0.25), true, true);
    add("touching from within at an edge", box, cube(0.25), at(0.75, 0.75, 0.25), true, true);
    add("touching from within at a corner", box, cube(0.25), at(0.75, 0.75, 0.75), true, true);
    const Mesh tetrahedron = mesh_of({{0, 0, 0}, {-0.5, 0.125, -0.25}, {-0.5, -0.25, 0.125}, {-0.75, 0.25, 0.25}},
                                     {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
    add("a corner on a face from within", box, tetrahedron, at(1, 0.25, 0.125), true, true);
    add("a corner on an edge from within", box, shifted(tetrahedron, {0, -0.5, 0}), at(1, 0.5, 0), true, true);
}

/// Surfaces within surfaces: the winding number determines the solid space between them.
void cavities(std::vector<BodyCase>& cases)
{
    const SolidFamily add{cases, "cavities"};
    const Mesh hollow = joined(cube(2), flipped(cube(1))), inside_out = flipped(hollow);
    const Mesh doubled = joined(cube(2), cube(1)), grain = cube(0x1p-10);
    for (const double gap : {0x1p-3, 0x1p-20, 0x1p-52}) {
        const auto name = [&](const char* what) { return fmt::format("{}, 2^{} m", what, std::log2(gap)); };
        const Mesh inner = cube(1 - gap);
        add(name("a box in a cavity"), hollow, inner, at(0, 0, 0), false, false);
        add(name("a box in a cavity, all inside out"), inside_out, inner, at(0, 0, 0), false, false);
        add(name("a box that fills no cavity"), doubled, inner, at(0, 0, 0), false, true);
        add(name("a shell in the wall"), hollow, cube(1 + gap), at(0, 0, 0), false, true);
        add(name("a shell around all"), hollow, cube(2 + 2 * gap), at(0, 0, 0), false, true);
        add(name("a shell in a cavity"), hollow, joined(inner, flipped(cube(0.5))), at(0, 0, 0), false, false);
        add(name("hollow in a cavity's wall"), hollow, joined(cube(1 + 2 * gap), flipped(cube(1 + gap))), at(0, 0, 0),
            false, true);
    }
    add("in the wall", hollow, grain, at(1.5, 0.25, 0.125), false, true);
    add("in the wall's corner", hollow, grain, at(1.5, 1.5, 1.5), false, true);
    add("in the cavity's corner", hollow, grain, at(0.875, 0.875, 0.875), false, false);
    add("touching the cavity's floor", hollow, cube(0.25), at(0.125, 0.25, -0.75), true, true);
    add("a box inside out, not in a cavity", joined(cube(1), flipped(shifted(cube(1), {4, 0, 0}))), grain,
        at(4, 0.125, 0), false, true);
    // Overlapping parts form their union; a part that is inside out cancels the other.
    add("where two parts overlap", joined(cube(1), shifted(cube(1), {1, 0.5, 0.25})), grain, at(0.5, 0.25, 0.125),
        false, true);
    add("where one cancels the other", joined(cube(1), flipped(shifted(cube(1), {1, 0.5, 0.25}))), grain,
        at(0.5, 0.25, 0.125), false, false);
}

/// Solids collide if any part is inside the other body.
void parts(std::vector<BodyCase>& cases)
{
    const SolidFamily add{cases, "several parts"};
    const Mesh box = cube(1), grain = cube(0x1p-6);
    Mesh outside = shifted(grain, {3, 0, 0});
    for (int k = 1; k < 5; ++k) outside = joined(outside, shifted(grain, {3.0 + k, 0.5 * k, 0}));
    const Mesh last_inside = joined(outside, shifted(grain, {0.5, 0.25, 0.125}));
    const Mesh first_inside = joined(shifted(grain, {0.5, 0.25, 0.125}), outside);
    const Mesh around = joined(shifted(grain, {-3, 0, 0}), shifted(grain, {3, 0, 0}));
    add("only the last inside", box, last_inside, at(0, 0, 0), false, true);
    add("only the first inside", box, first_inside, at(0, 0, 0), false, true);
    add("none inside", box, outside, at(0, 0, 0), false, false);
    add("on two sides", box, around, at(0, 0, 0), false, false);
    add("one of the outer ones holds", joined(shifted(box, {-4, 0, 0}), box), grain, at(0.5, 0.25, 0), false, true);
    add("between the outer ones", joined(shifted(box, {-4, 0, 0}), box), grain, at(-2, 0.25, 0), false, false);
    add("each holds a part of the other", joined(box, shifted(grain, {4, 0, 0})),
        joined(shifted(box, {4, 0, 0}), grain), at(0, 0, 0), false, true);
    add("only the second holds a part", joined(box, shifted(grain, {4, 0, 0})), shifted(box, {4, 0.25, 0}), at(0, 0, 0),
        false, true);
    add("parts that share a corner", cube(2),
        joined(shifted(grain, Vector3d::Constant(-0x1p-6)), shifted(grain, Vector3d::Constant(0x1p-6))), at(0.5, 0, 0),
        false, true);
    add("one part touches from within", box, joined(outside, shifted(grain, {1 - 0x1p-6, 0, 0})), at(0, 0, 0), true,
        true);
}

/// The same cases small and large, and far from the origin.
void sizes(std::vector<BodyCase>& cases)
{
    const SolidFamily add{cases, "solids of all sizes and places"};
    const Mesh box = cube(1), ball = make_sphere_mesh(0.5, 60), hollow = joined(cube(2), flipped(box));
    const Eigen::Matrix3d none = Eigen::Matrix3d::Identity(), turn = turn_by(1, {3, 1, 2});
    for (int exponent = -9; exponent <= 9; exponent += 3) {
        const double s = std::pow(10, exponent);
        const auto name = [&](const char* what) { return fmt::format("1e{}, {}", exponent, what); };
        add(name("a ball in a box"), scaled(box, s), scaled(ball, s), at(s * Vector3d(0.2, 0.1, 0.3), turn), false,
            true);
        add(name("a ball beside a box"), scaled(box, s), scaled(ball, s), at(s * Vector3d(1.6, 0.1, 0.3), turn), false,
            false);
        add(name("a ball in a cavity"), scaled(hollow, s), scaled(ball, s), at(s * Vector3d(0.2, 0.1, 0.3), turn),
            false, false);
        add(name("a box in a wall"), scaled(hollow, s), scaled(cube(0.25), s), at(s * Vector3d(1.5, 0, 0), none), false,
            true);
    }
    for (const double offset : {1e4, 1e6, 1e8}) {
        const Vector3d far(offset, -offset, offset / 2), aside(0.25, 0.125, 0);
        const auto name = [&](const char* what) { return fmt::format("{}, {}", offset, what); };
        add(name("a ball in a box"), box, ball, at(far + aside, turn), false, true, at(far, none));
        add(name("a ball in a cavity"), hollow, ball, at(far + aside, turn), false, false, at(far, turn));
        add(name("files far from their origins"), shifted(hollow, far), shifted(cube(0.25), far), at(1.5, 0.25, 0.125),
            false, true);
        add(name("files far away, moved back"), shifted(hollow, far), cube(0.25), at(0.25, 0.125, 0), false, false,
            at(-far, none));
    }
}

} // namespace

std::vector<BodyCase> solid_cases()
{
    std::vector<BodyCase> cases;
    enclosed(cases), cavities(cases), parts(cases), grains(cases), sizes(cases);
    return cases;
}

} // namespace oncollide::tools
