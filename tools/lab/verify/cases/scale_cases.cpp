// One body inside another, tiny and huge bodies, bodies near and far from the origin, and bodies that slide along
// others.
#include <cmath>

#include <fmt/format.h>

#include <oncollide/samples/generators.hpp>

#include "verify/cases/body_case.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

/// For surfaces: a collision only if the surfaces meet.
void nested(std::vector<BodyCase>& cases)
{
    const Mesh cube = make_box_mesh({1, 1, 1}), sphere = make_sphere_mesh(1, 128);
    const CaseFamily inside{cases, "a mesh inside another"}, shells{cases, "concentric shells"};
    inside("a box in a box", cube, make_box_mesh({0.25, 0.5, 0.125}), at(0.125, 0.25, -0.5), false);
    inside("a box on a box's floor", cube, make_box_mesh({0.25, 0.5, 0.125}), at(0.125, 0.25, -0.875), true);
    inside("a box in a box's corner", cube, make_box_mesh({0.25, 0.5, 0.125}), at(-0.75, 0.5, -0.875), true);
    inside("a sphere in a box", cube, scaled(sphere, 0.9), at(0, 0, 0), false);
    inside("a sphere that a box holds", cube, sphere, at(0, 0, 0), true);
    inside("a knot in a sphere", scaled(sphere, 4), make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 120), at(0.5, 0, 0.25),
           false);
    inside("a dust grain in a box", cube, make_box_mesh(Vector3d::Constant(1e-9)), at(0.1, 0.2, 0.3), false);
    for (double gap : {0.1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15})
        for (bool box : {false, true})
            shells(fmt::format("{}, {} m apart", box ? "boxes" : "spheres", gap), box ? cube : sphere,
                   scaled(box ? cube : sphere, 1 - gap), at(0, 0, 0), false);
}

void scales(std::vector<BodyCase>& cases)
{
    const Mesh cube = make_box_mesh({0.5, 0.25, 0.5}), knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 120);
    const Eigen::Matrix3d turn = turn_by(1, {3, 1, 2});
    for (int exponent = -9; exponent <= 9; exponent += 3) {
        const double near = std::pow(10, exponent), two = std::ldexp(1, int(std::lround(exponent * std::log2(10))));
        const CaseFamily family{cases, "scales 1e-9 to 1e9", fmt::format("1e{}, ", exponent)};
        const auto add = [&](const char* name, const Mesh& mesh, const Eigen::Isometry3d& pose, bool collide) {
            family(name, mesh, mesh, pose, collide);
        };
        add("boxes that touch", scaled(cube, two), at(two, 0.125 * two, 0), true);
        add("boxes an ulp apart", scaled(cube, two), at(std::nextafter(two, 2 * two), 0.125 * two, 0), false);
        add("knots", scaled(knot, near), at(near * Vector3d(0.4, 0.2, 0.3), turn), true);
        add("knots apart", scaled(knot, near), at(near * Vector3d(3.1, 0, 0.3), turn), false);
    }
}

void offsets(std::vector<BodyCase>& cases)
{
    const Mesh cube = make_box_mesh({0.5, 0.25, 0.5}), knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 120);
    const Eigen::Matrix3d turn = turn_by(1, {3, 1, 2}), none = Eigen::Matrix3d::Identity();
    for (double offset : {1e2, 1e4, 1e6, 1e8}) {
        const Vector3d far(offset, -offset, offset / 2);
        const auto add = [&](const char* name, const Mesh& a, const Mesh& b, Eigen::Isometry3d pose_a,
                             Eigen::Isometry3d pose, std::optional<bool> collide) {
            cases.push_back({"offsets to 1e8", fmt::format("{}, {}", offset, name), a, b, pose_a, {pose}, collide});
        };
        const auto moved = [&](const Mesh& mesh) { return shifted(mesh, far); };
        add("boxes that touch far away", cube, cube, at(far, none), at(far + Vector3d(1, 0.125, 0), none), true);
        add("boxes 2^-20 apart far away", cube, cube, at(far, none), at(far + Vector3d(1 + 0x1p-20, 0.125, 0), none),
            false);
        add("knots far away", knot, knot, at(far, turn), at(far + Vector3d(0.4, 0.2, 0.3), none), true);
        add("files far from their origins", moved(cube), moved(cube), at(0, 0, 0), at(1, 0.125, 0), true);
        add("a file far from its origin", moved(cube), cube, at(0, 0, 0), at(far + Vector3d(1, 0.125, 0), none), true);
        add("knots in files far from their origins", moved(knot), moved(knot), at(0, 0, 0), at(0.4, 0.2, 0.3), true);
        add("knots apart, in such files", moved(knot), moved(knot), at(0, 0, 0), at(3.1, 0, 0.3), false);
        add("files far away, moved back", moved(cube), cube, at(-far, none), at(1, 0.125, 0), true);
    }
}

/// Two spikes, tip to tip: their boxes overlap by no more than the tips do. In files far from their origins, which the
/// poses compensate, sums of large numbers leave small ones.
void spikes(std::vector<BodyCase>& cases)
{
    const Mesh spike = mesh_of({{0, 0, 0}, {1, 0x1p-6, 0}, {1, -0x1p-6, 0x1p-6}, {1, 0, -0x1p-6}},
                               {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
    const Eigen::Matrix3d none = Eigen::Matrix3d::Identity();
    for (double offset : {0.0, 1e6, 1e8})
        for (double size : {1.0, 0x1p-10, 1e-5})
            for (int k : {1, 31, 35, 40, 43}) {
                const Vector3d far(offset, -offset, offset / 2);
                const Mesh a = rotated(spike, size * none, far), b = rotated(spike, -size * none, far);
                const Eigen::Matrix3d turn = turn_by(0.9 + 0.1 * k, {1, 2, 3.0 - k});
                const Eigen::Isometry3d back = at(turn * -far, turn);
                const std::string name =
                    fmt::format("spikes of {} m tip to tip, {} from their origins, turn {}", size, offset, k);
                cases.push_back({"offsets to 1e8", name, a, b, back, {back}, {}});
            }
}

void mixed_sizes(std::vector<BodyCase>& cases)
{
    const double s = 0x1p-10, l = 0x1p17; // about 1e-3 and 1e5
    const Mesh small = make_box_mesh({s, s, s}), large = make_box_mesh({l, l, l}), ball = make_sphere_mesh(1e5, 128);
    const Mesh grain = make_sphere_mesh(1e-3, 32);
    const CaseFamily add{cases, "sizes 1e-3 and 1e5"};
    add("on a face", large, small, at(1000, -3000, l + s), true);
    add("on a face's diagonal", large, small, at(1000, 1000, l + s), true);
    add("on a corner", large, small, at(l + s, -l - s, l + s), true);
    add("off a face by 2^-30", large, small, at(1000, -3000, l + s + 0x1p-30), false);
    add("off a corner by 2^-30", large, small, at(l + s, -l - s, l + s + 0x1p-30), false);
    add("inside", large, small, at(1000, -3000, 0), false);
    add("inside, off the face", large, small, at(1000, -3000, l - s - 0x1p-30), false);
    add("through a face", large, grain, at(12345.678, -3210.123, l), true);
    add("on the pole of a ball", ball, grain, at(0, 0, 1e5), true);
    add("over the pole of a ball", ball, grain, at(0, 0, 1e5 + 2e-3), false);
    add("a large needle by a grain", mesh_of({{-l, 0, 0}, {l, 0, 0}, {l, s, 0}}), grain, at(777.7, 0.0011, 0));
}

/// Motions in which bodies slide along each other. Each pose is a case, and the trees keep their state from the last
/// pose.
void grazing(std::vector<BodyCase>& cases)
{
    const Mesh cube = make_box_mesh({0.5, 0.5, 0.5}), floor = make_box_mesh({4, 4, 0.25}),
               sphere = make_sphere_mesh(1, 128);
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 120);
    const auto add = [&](const char* name, const Mesh& a, const Mesh& b, std::optional<bool> collide, auto pose_of) {
        BodyCase& c = cases.emplace_back(BodyCase{"grazing motion", name, a, b, at(0, 0, 0), {}, collide});
        for (int k = 0; k < 16; ++k) c.poses_b.push_back(pose_of(k));
    };
    const double top = 0.75, over = std::nextafter(0.75, 1);
    add("a box slides on a floor", floor, cube, true, [&](int k) { return at(0.5 * k - 4, 0.25, top); });
    add("a box slides an ulp over a floor", floor, cube, false, [&](int k) { return at(0.5 * k - 4, 0.25, over); });
    add("a box slides off an edge", floor, cube, {}, [&](int k) { return at(4 + k / 16.0, 0.5, top); });
    add("a box slides along a box's edge", cube, cube, {}, [&](int k) { return at(1, 1, k / 8.0 - 1); });
    add("a sphere's corner runs along a floor", floor, sphere, true, [&](int k) { return at(0.4 * k - 3, 0.1, 1.25); });
    add("a sphere rolls on a floor", floor, sphere, {}, [&](int k) {
        return at({0.1 * k, 0, 1.25}, turn_by(0.1 * k, Vector3d::UnitY()));
    });
    add("a knot passes a knot", knot, knot, {}, [&](int k) {
        return at({2.35 - 0.01 * k, 0.3, 0.1}, turn_by(0.02 * k, {1, 2, 3}));
    });
    add("a box comes to rest", floor, cube, {},
        [&](int k) { return at(0.25, 0.5, top + (k < 12 ? std::pow(10, -k) : 0)); });
}

} // namespace

std::vector<BodyCase> scale_cases()
{
    std::vector<BodyCase> cases;
    nested(cases), scales(cases), offsets(cases), spikes(cases), mixed_sizes(cases), grazing(cases);
    return cases;
}

} // namespace oncollide::tools
