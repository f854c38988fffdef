// Unusual meshes: slivers, needles, triangles without area, duplicate triangles, open and
// non-manifold surfaces, single triangles.
#include <cmath>

#include <fmt/format.h>

#include <oncollide/samples/generators.hpp>

#include "verify/cases/body_case.hpp"
#include "verify/cases/triangle_families.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

Mesh sliver_mesh(double aspect)
{
    const double width = 1 / aspect;
    return mesh_of({{-0.5, 0, 0}, {0.5, 0, 0}, {0, width, 0}, {0.25, 0, width}, {-0.5, width, width}},
                   {{0, 1, 2}, {0, 1, 3}, {0, 2, 4}});
}

void slivers(std::vector<BodyCase>& cases)
{
    const Mesh cube = make_box_mesh({0.5, 0.5, 0.5});
    for (double aspect : {1e6, 1e9, 1e12}) {
        const Mesh sliver = sliver_mesh(aspect);
        const CaseFamily add{cases, "sliver meshes", fmt::format("1 : {}, ", aspect)};
        add("crossing", sliver, sliver, at({0, 0, 0}, turn_by(2 * std::atan(1.0), Vector3d::UnitZ())));
        add("along each other", sliver, sliver, at(0.25, 0, 0), true);
        add("end on end", sliver, sliver, at(1, 0, 0), true);
        add("beside each other", sliver, sliver, at(0, -2 / aspect, 0), false);
        add("sticking in a box", cube, sliver, at(0.75, 0.1, 0.2), true);
        add("inside a box", make_box_mesh({1, 1, 1}), sliver, at(0.1, 0.1, 0.2), false);
        add("on a face of a box", cube, sliver, at(0.125, 0.25, 0.5), true);
        add("over a face of a box", cube, sliver, at(0.125, 0.25, 0.5 + 1e-13), false);
        add("turned, in a box", cube, sliver, at({0.7, 0.1, 0.2}, turn_by(1, {1, 2, 3})));
    }
}

void needles(std::vector<BodyCase>& cases)
{
    const Mesh needles = make_needles_mesh(40, 1, 1e5, 1.5, 5), others = make_needles_mesh(40, 1, 1e3, 1.5, 9);
    const Mesh torus = make_torus_mesh(0.6, 0.2, 160);
    const CaseFamily add{cases, "needles"};
    for (int k = 0; k < 4; ++k) {
        const Eigen::Matrix3d turn = turn_by(0.5 + k, {1.0 + k, 2, 3});
        add(fmt::format("among needles {}", k), needles, others, at({0.1 * k, 0.2, 0.1}, turn));
        add(fmt::format("in a ring {}", k), torus, needles, at({0.1, 0.1 * k, 0}, turn));
    }
    const Mesh x = mesh_of({{-1, 0, 0}, {1, 0, 0}, {1, 0x1p-30, 0}}),
               y = mesh_of({{0, -1, 0}, {0, 1, 0}, {0, 1, 0x1p-30}});
    add("two that cross", x, y, at(0.25, 0.125, 0), true);
    add("two that cross in their ends", x, y, at(1, 1, 0), true);
    for (double gap : {1e-3, 1e-9, 1e-15})
        add(fmt::format("two that pass at {} m", gap), x, y, at(0.25, 0.125, gap), false);
    const Mesh through = mesh_of({{0, 0, -5}, {0, 0, 5}, {1e-7, 0, 5}});
    add("through the hole of a ring", torus, through, at(0.1, 0.05, 0), false);
    add("through the tube of a ring", torus, through, at(0.6, 0.05, 0), true);
}

/// `mesh` plus a triangle at a vertex, one along an edge, and a duplicate of each triangle.
Mesh littered(Mesh mesh)
{
    const std::vector<Triangle> once = mesh.triangles;
    mesh.triangles.insert(mesh.triangles.end(), once.begin(), once.end());
    for (const Triangle& t : once)
        mesh.triangles.push_back({t[0], t[0], t[0]}), mesh.triangles.push_back({t[1], t[2], t[1]});
    return mesh_of(std::move(mesh.vertices), std::move(mesh.triangles));
}

/// The mesh without shared vertices: three per triangle.
Mesh unshared(const Mesh& mesh)
{
    std::vector<Vector3d> corners;
    for (const Triangle& t : mesh.triangles)
        for (std::uint32_t v : t) corners.push_back(mesh.vertices[v]);
    return mesh_of(corners);
}

void degenerate_triangles(std::vector<BodyCase>& cases)
{
    const Mesh cube = make_box_mesh({0.5, 0.5, 0.5}), point = mesh_of({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}});
    const Mesh segment = mesh_of({{-0.5, 0, 0}, {0.25, 0, 0}, {0.5, 0, 0}});
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 120);
    const CaseFamily no_area{cases, "zero-area triangles"}, twice{cases, "duplicate triangles and vertices"};
    no_area("a point on a face", cube, point, at(0.25, 0.125, 0.5), true);
    no_area("a point on a corner", cube, point, at(0.5, 0.5, 0.5), true);
    no_area("a point off a face", cube, point, at(0.25, 0.125, std::nextafter(0.5, 1)), false);
    no_area("a point inside", cube, point, at(0.25, 0.125, 0), false);
    no_area("a point on a point", point, point, at(0, 0, 0), true);
    const Mesh two = mesh_of({{-5, 0, 0}, {-5, 0, 0}, {-5, 0, 0}, {5, 0, 0}, {5, 0, 0}, {5, 0, 0}});
    no_area("two points beside two points", two, two,
            at({0.3, 0.2, 0.1}, turn_by(2 * std::atan(1.0), Vector3d::UnitZ())), false);
    no_area("a point off a point", point, point, at(0, 0x1p-1060, 0), false);
    no_area("a segment through a face", cube, segment, at(0.5, 0.125, 0.25), true);
    no_area("a segment on a face", cube, segment, at(0.125, 0.125, 0.5), true);
    no_area("a segment on an edge", cube, segment, at(0.75, 0.5, -0.5), true);
    no_area("a segment beyond an edge", cube, segment, at(0.125, 0.5, std::nextafter(0.5, 1)), false);
    no_area("segments end on end", segment, segment, at(1, 0, 0), true);
    twice("boxes that touch", littered(cube), littered(cube), at(1, 0.25, 0.125), true);
    twice("boxes an ulp apart", littered(cube), unshared(cube), at(0.25, std::nextafter(1, 2), 0.125), false);
    twice("knots", littered(knot), unshared(knot), at({0.4, 0.2, 0.3}, turn_by(1, {3, 1, 2})), true);
    twice("knots apart", unshared(knot), littered(knot), at({3.1, 0, 0.3}, turn_by(1, {3, 1, 2})), false);
    twice("the same without shared vertices", knot, unshared(knot), at(0, 0, 0), true);
}

void open_meshes(std::vector<BodyCase>& cases)
{
    Mesh tub = make_box_mesh({0.5, 0.5, 0.5}); // without its top
    std::erase_if(tub.triangles, [&](const Triangle& t) {
        return tub.vertices[t[0]].z() > 0 && tub.vertices[t[1]].z() > 0 && tub.vertices[t[2]].z() > 0;
    });
    tub = mesh_of(std::move(tub.vertices), std::move(tub.triangles));
    const Mesh rod = make_box_mesh({0.125, 0.125, 1}), terrain = make_terrain_mesh(2, 0.4, 8, 3);
    const Mesh fan = mesh_of({{0, 0, -1}, {0, 0, 1}, {1, 0, 0}, {-0.5, 1, 0}, {-0.5, -1, 0}},
                             {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}); // three on one edge
    const Mesh bow = mesh_of({{0, 0, 0}, {1, 0.5, 0}, {1, -0.5, 0}, {-1, 0.5, 0}, {-1, -0.5, 0}},
                             {{0, 1, 2}, {0, 3, 4}}); // two that share only a vertex
    const CaseFamily add{cases, "open and non-manifold"};
    add("a rod through the open side", tub, rod, at(0.125, 0.125, 0.75), false);
    add("a rod that stands on the floor", tub, rod, at(0.125, 0.125, 0.5), true);
    add("a rod that leans on the rim", tub, rod, at(0.5, 0.125, 1.5), true);
    add("terrain under terrain", terrain, terrain, at(0, 0, 1), false);
    add("terrain through terrain", terrain, terrain, at({0, 0, 0.05}, turn_by(1, Vector3d::UnitZ())), true);
    add("three fins across each other", fan, fan, at(0.25, 0.125, 0), true);
    add("three fins edge on edge", fan, fan, at(0, 0, 2), true);
    add("three fins past each other", fan, fan, at(1.125, 0.0625, 2), false);
    add("a corner on a shared corner", bow, fan, at(-1, 0, 0), true);
    add("a fin through a bow", fan, bow, at(0.25, 0, 0.25), true);
}

/// A few pairs of each family of triangle pairs, each triangle a mesh.
void lone_triangles(std::vector<BodyCase>& cases)
{
    const CaseFamily add{cases, "meshes of one triangle"};
    for (const TriangleFamily& family : triangle_families()) {
        GridPoints random(11);
        for (int k = 0; k < 4; ++k) {
            const auto [a, b] = moved(family.make(random), 0x1p-20 * Eigen::Matrix3d::Identity(), {0, 0, 0});
            add(fmt::format("{} {}", family.name, k), mesh_of({a[0], a[1], a[2]}), mesh_of({b[0], b[1], b[2]}),
                at(0, 0, 0));
        }
    }
}

} // namespace

std::vector<BodyCase> shape_cases()
{
    std::vector<BodyCase> cases;
    slivers(cases), needles(cases), degenerate_triangles(cases), open_meshes(cases), lone_triangles(cases);
    return cases;
}

} // namespace oncollide::tools
