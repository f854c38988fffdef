// Bodies that touch without crossing, overlap in a plane, are identical, or are parallel at a distance near rounding.
#include <cmath>

#include <fmt/format.h>

#include <oncollide/samples/generators.hpp>

#include "verify/cases/body_case.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

/// Coordinates are small multiples of powers of two, so touching is exact.
void touching_boxes(std::vector<BodyCase>& cases)
{
    const Mesh cube = make_box_mesh({0.5, 0.5, 0.5}), small = make_box_mesh({0.125, 0.25, 0.125});
    const CaseFamily family{cases, "touching boxes"};
    const auto add = [&](const char* name, const Mesh& b, const Eigen::Isometry3d& pose, bool collide) {
        family(name, cube, b, pose, collide);
    };
    add("face on face", cube, at(1, 0, 0), true);
    add("face on part of a face", cube, at(0.25, 0.375, -1), true);
    add("small face inside a face", small, at(0.25, 0.75, 0.125), true);
    add("face on face, corner on edge", small, at(0.375, 0.75, 0.375), true);
    add("edge on edge", cube, at(-1, 1, 0), true);
    add("edge on part of an edge", cube, at(1, 0.5, -1), true);
    add("corner on corner", cube, at(1, -1, 1), true);
    add("an ulp off the face", cube, at(std::nextafter(1, 2), 0.25, 0), false);
    add("an ulp off the edge", cube, at(1, std::nextafter(1, 2), 0), false);
    add("an ulp off the corner", cube, at(std::nextafter(-1, -2), -1, 1), false);
    add("an ulp into the face", cube, at(std::nextafter(1, 0), 0.25, 0), true);
    // A vertex on a face and an edge across an edge: meshes whose vertices and edges are on the grid.
    const Mesh pyramid = mesh_of({{0, 0, 0}, {0.5, 0.125, 1}, {-0.5, 0.25, 1}, {0.125, -0.5, 1}},
                                 {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
    add("corner on a face", pyramid, at(0.25, -0.125, 0.5), true);
    add("corner on a face's diagonal", pyramid, at(0.25, 0.25, 0.5), true);
    add("corner on an edge", pyramid, at(0.5, 0.125, 0.5), true);
    add("corner off a face", pyramid, at(0.25, -0.125, std::nextafter(0.5, 1)), false);
    const Mesh roof = mesh_of({{-1, 0, 0}, {1, 0, 0}, {-1, -0.5, 1}, {1, -0.5, 1}, {-1, 0.5, 1}, {1, 0.5, 1}},
                              {{0, 1, 3}, {0, 3, 2}, {0, 5, 1}, {0, 4, 5}, {2, 3, 5}, {2, 5, 4}});
    add("edge across a face", roof, at(0.125, 0.0625, 0.5), true);
    add("edge across an edge", rotated(roof, turn_by(std::atan(1.0), Vector3d::UnitY()), {0, 0, 0}), at(0.5, 0, 0.5),
        true);
}

/// Walls and boxes as in buildings: lengths in decimals, so coordinates are rounded.
void walls(std::vector<BodyCase>& cases)
{
    const auto add = [&](const char* name, Vector3d a, Vector3d b, Eigen::Isometry3d pose) {
        cases.push_back({"coplanar walls", name, make_box_mesh(a), make_box_mesh(b), at(0.3, 0.7, 1.1), {pose}, {}});
    };
    add("overlap by 50 mm, faces aligned", {2, 0.1, 1.25}, {2, 0.1, 1.25}, at(0.3 + 3.95, 0.7, 1.1));
    add("overlap by 50 mm, one higher", {2, 0.1, 1.25}, {2, 0.1, 1.5}, at(0.3 + 3.95, 0.7, 1.35));
    add("a corner of two walls", {2, 0.1, 1.25}, {0.1, 2, 1.25}, at(0.3 + 1.9, 0.7 + 1.9, 1.1));
    add("end on end", {2, 0.1, 1.25}, {2, 0.1, 1.25}, at(0.3 + 4, 0.7, 1.1));
    add("equal boxes stacked", {0.3, 0.2, 0.1}, {0.3, 0.2, 0.1}, at(0.3, 0.7, 1.1 + 0.2));
    add("equal boxes stacked askew", {0.3, 0.2, 0.1}, {0.3, 0.2, 0.1}, at(0.37, 0.77, 1.1 + 0.2));
    add("small box on a large one", {0.3, 0.2, 0.1}, {0.1, 0.1, 0.1}, at(0.3, 0.7, 1.1 + 0.2));
    add("small box on a corner", {0.3, 0.2, 0.1}, {0.1, 0.1, 0.1}, at(0.3 + 0.2, 0.7 + 0.1, 1.1 + 0.2));
    add("large box on a small one", {0.1, 0.1, 0.1}, {0.3, 0.2, 0.1}, at(0.3, 0.7, 1.1 + 0.2));
    add("sunk in by a nanometre", {0.3, 0.2, 0.1}, {0.3, 0.2, 0.1}, at(0.3, 0.7, 1.1 + 0.2 - 1e-9));
    add("lifted by a nanometre", {0.3, 0.2, 0.1}, {0.3, 0.2, 0.1}, at(0.3, 0.7, 1.1 + 0.2 + 1e-9));
}

void twins(std::vector<BodyCase>& cases)
{
    const std::pair<const char*, Mesh> kinds[] = {{"box", make_box_mesh({0.5, 0.3, 0.2})},
                                                  {"sphere", make_sphere_mesh(1, 128)},
                                                  {"knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 200)},
                                                  {"terrain", make_terrain_mesh(2, 0.3, 8, 7)},
                                                  {"needles", make_needles_mesh(30, 1, 1e5, 2, 7)},
                                                  {"soup", make_soup_mesh(60, 0.5, 1.5, 6)}};
    const Eigen::Matrix3d turn = turn_by(0.7, {1, 2, 3});
    for (const auto& [name, mesh] : kinds) {
        cases.push_back({"identical meshes", name, mesh, mesh, at(0, 0, 0), {at(0, 0, 0)}, true});
        const Eigen::Isometry3d far = at(Vector3d(1e6, -1e6, 3.3e5), turn);
        cases.push_back({"identical meshes", fmt::format("{}, turned and far", name), mesh, mesh, far, {far}, {}});
    }
}

void plates(std::vector<BodyCase>& cases)
{
    const Mesh plate = mesh_of({{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}}, {{0, 1, 2}, {0, 2, 3}});
    const CaseFamily family{cases, "nearly parallel plates"};
    const auto add = [&](const std::string& name, double height, double tilt, bool collide) {
        const Eigen::Matrix3d turn = tilt == 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) // not -0
                                               : turn_by(tilt, {1, 2, 0});
        family(name, plate, plate, at(Vector3d(0.125, 0.25, height), turn), collide);
    };
    for (double gap : {0.0, 1e-9, 1e-12, 1e-15, 1e-18, 1e-60}) add(fmt::format("{} m apart", gap), gap, 0, gap == 0);
    for (double tilt : {1e-6, 1e-9, 1e-12, 1e-15}) {
        add(fmt::format("tilted by {}, crossing", tilt), tilt, tilt, true);
        add(fmt::format("tilted by {}, apart", tilt), 4 * tilt, tilt, false);
    }
}

} // namespace

std::vector<BodyCase> contact_cases()
{
    std::vector<BodyCase> cases;
    touching_boxes(cases), walls(cases), twins(cases), plates(cases);
    return cases;
}

} // namespace oncollide::tools
