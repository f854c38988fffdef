#include "bench/contacts/contact_scenes.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

#include "bench/contacts/shape_scenes.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

std::shared_ptr<const Geometry> geometry(GeometryData data)
{
    return std::make_shared<const Geometry>(Geometry{"", std::move(data), {}});
}

Isometry3d at(const Vector3d& p)
{
    return Isometry3d(Eigen::Translation3d(p));
}

Isometry3d turned(const Vector3d& p, std::uint64_t seed)
{
    const auto draw = [&](std::uint64_t k) { return 2 * u01(seed, 7, k) - 1; };
    return at(p) * Eigen::AngleAxisd(M_PI * draw(0), Vector3d(draw(1), draw(2), draw(3)).normalized());
}

/// A body with four legs and a head: closed, concave, about 0.5 m long.
Mesh animal()
{
    Mesh mesh = make_sphere_mesh(1, 1500);
    const std::pair<Vector3d, double> limbs[] = {{{0.5, 0.3, -0.8}, 1.0},  {{0.5, -0.3, -0.8}, 1.0},
                                                 {{-0.5, 0.3, -0.8}, 1.0}, {{-0.5, -0.3, -0.8}, 1.0},
                                                 {{0.9, 0, 0.45}, 0.9},    {{-0.95, 0, 0.2}, 0.5}};
    for (Vector3d& v : mesh.vertices) {
        const Vector3d d = v.normalized();
        double reach = 1 / std::sqrt(d.x() * d.x() + 4 * d.y() * d.y() + 4 * d.z() * d.z());
        for (const auto& [way, length] : limbs) reach += length * std::exp(30 * (d.dot(way.normalized()) - 1));
        v = 0.15 * reach * d;
    }
    return make_mesh("animal", mesh.vertices, mesh.triangles);
}

/// The half-extents of a geometry with its centre at the origin.
Vector3d half_of(const Geometry& g)
{
    const Aabb& box = std::get<Mesh>(g.data).bounds;
    return 0.5 * (box.max - box.min);
}

/// Five boxes, each a little beside the one below; as shapes, or as meshes with `cells` cells along an edge.
ContactScene stack(int cells)
{
    const Vector3d half(0.25, 0.25, 0.25);
    ContactScene scene{.name = cells ? fmt::format("stack-{}", 12 * cells * cells) : "stack-shapes",
                       .what = cells ? fmt::format("5 boxes of {} triangles", 12 * cells * cells) : "5 boxes as shapes",
                       .steps = 1000,
                       .timed = 50,
                       .most_creep = 1e-6};
    scene.bodies.push_back({.geometry = geometry(Shape(Box{{5, 5, 1}})), .pose = at({0, 0, -1})});
    const auto box = geometry(cells ? GeometryData(make_box_mesh(half, cells)) : GeometryData(Shape(Box{half})));
    for (int i = 0; i < 5; ++i)
        scene.bodies.push_back(
            {.geometry = box, .pose = at({0.01 * (i % 2), 0.013 * (i % 3), 0.25 + 0.5 * i}), .half = half});
    return scene;
}

/// Twenty bodies that fall into a square with walls.
ContactScene pile(std::string name, std::string what, const std::shared_ptr<const Geometry>& mesh)
{
    ContactScene scene{
        .name = std::move(name), .what = std::move(what), .steps = 4000, .timed = 50, .most_creep = 1e-3};
    scene.friction = 0.6;
    const Vector3d half = half_of(*mesh);
    const double size = half.norm();
    scene.bodies.push_back({.geometry = geometry(Shape(Box{{6 * size, 6 * size, 1}})), .pose = at({0, 0, -1})});
    for (const auto& [x, y] : {std::pair(1, 0), std::pair(-1, 0), std::pair(0, 1), std::pair(0, -1)}) {
        const Vector3d wall(x ? 0.5 : 6 * size, y ? 0.5 : 6 * size, 10 * size);
        const double beside = 2.2 * size + 0.5;
        scene.bodies.push_back(
            {.geometry = geometry(Shape(Box{wall})), .pose = at({x * beside, y * beside, 10 * size})});
    }
    for (int i = 0; i < 20; ++i) {
        const Vector3d p(1.1 * size * (i % 2 ? 1 : -1), 1.1 * size * (i / 2 % 2 ? 1 : -1),
                         size * (1.1 + 2.2 * (i / 4)));
        scene.bodies.push_back({.geometry = mesh, .pose = turned(p, static_cast<std::uint64_t>(i)), .half = half});
    }
    return scene;
}

ContactScene knots(int triangles, const Vector3d& apart, std::string name, std::string what)
{
    const auto knot = geometry(make_torus_knot_mesh(2, 3, 0.4, 0.2, 0.08, triangles));
    ContactScene scene{.name = std::move(name), .what = std::move(what)};
    scene.margin = 0;
    scene.bodies.push_back({.geometry = knot});
    scene.bodies.push_back({.geometry = knot, .pose = turned(apart, 3), .half = half_of(*knot)});
    return scene;
}

/// Concave bodies with flat faces that fall on each other.
ContactScene gears()
{
    ContactScene scene{.name = "gears",
                       .what = "3 gears fall on each other",
                       .dt = 0.004,
                       .margin = 0.005,
                       .steps = 1000,
                       .timed = 50};
    scene.friction = 0.8, scene.most_creep = 1e-5;
    scene.bodies.push_back({.geometry = geometry(Shape(Box{{3, 3, 1}})), .pose = at({0, 0, -1})});
    const auto gear = geometry(make_gear_mesh(8, 0.25, 0.35, 0.2, 0.1));
    for (int i = 0; i < 3; ++i)
        scene.bodies.push_back({.geometry = gear,
                                .pose = at({0.2 * (i % 2), 0.15 * (i % 3), 0.15 + 0.24 * i}),
                                .half = {0.35, 0.35, 0.1}});
    return scene;
}

ContactScene sliding(int cells)
{
    const int triangles = 12 * cells * cells;
    ContactScene scene{.name = fmt::format("sliding-{}", triangles),
                       .what = fmt::format("a mesh box slides over {} triangles, no friction", triangles),
                       .steps = 1000,
                       .timed = 50};
    scene.friction = 0;
    const Vector3d half(0.25, 0.2, 0.1);
    scene.bodies.push_back({.geometry = geometry(make_box_mesh({4, 4, 1}, cells)), .pose = at({0, 0, -1})});
    scene.bodies.push_back({.geometry = geometry(make_box_mesh(half)),
                            .pose = at({-2, 0.0123, 0.1}),
                            .half = half,
                            .velocity = {2, 0.3, 0}});
    return scene;
}

ContactScene enclosed(bool shape)
{
    ContactScene scene{.name = shape ? "enclosed-shape" : "enclosed-mesh",
                       .what = shape ? "a box inside a mesh" : "a mesh inside a mesh"};
    const Vector3d half(0.05, 0.05, 0.05);
    scene.bodies.push_back({.geometry = geometry(make_sphere_mesh(0.5, 2048))});
    scene.bodies.push_back({.geometry = geometry(shape ? GeometryData(Shape(Box{half})) : make_box_mesh(half)),
                            .pose = turned({0.1, 0.2, 0.1}, 5),
                            .half = half});
    return scene;
}

/// The nut of IsaacGym's factory on its bolt, without friction.
ContactScene nut_and_bolt(const ContactFiles& files)
{
    ContactScene scene{.name = "nut", .what = "a nut turns down its bolt, no friction", .steps = 1300, .timed = 50};
    scene.friction = 0, scene.margin = 1e-5, scene.slop = 1e-6;
    const auto nut = geometry(load_mesh(files.nut, {.centre = true}));
    scene.bodies.push_back({.geometry = geometry(load_mesh(files.bolt))});
    scene.bodies.push_back({.geometry = nut, .pose = at({0, 0, 0.0344}), .half = half_of(*nut)});
    return scene;
}

std::vector<ContactEntry> entries(const ContactFiles& files, int bodies)
{
    std::vector<ContactEntry> all;
    for (const int cells : {0, 1, 10, 32})
        all.push_back(
            {cells ? fmt::format("stack-{}", 12 * cells * cells) : "stack-shapes", [=] { return stack(cells); }});
    all.push_back({"knots-1500", [] {
                       return knots(1500, {0.1, 0.33, 0.1}, "knots-1500", "two knots of 1,500 triangles");
                   }});
    all.push_back(
        {"knots-5000", [] {
             return knots(5000, {0.05, 0.03, 0.02}, "knots-5000", "two knots of 5,000 triangles in deep overlap");
         }});
    all.push_back({"pile-knots", [] {
                       return pile("pile-knots", "20 knots of 600 triangles",
                                   geometry(make_torus_knot_mesh(2, 3, 0.4, 0.2, 0.08, 600)));
                   }});
    all.push_back({"pile-cows", [cow = files.cow] {
                       return pile(
                           "pile-cows",
                           cow.empty() ? "20 animals of 1,500 triangles"
                                       : "20 of " + std::filesystem::path(cow).filename().string(),
                           geometry(cow.empty() ? animal() : load_mesh(cow, {.fit_diagonal = 0.6, .centre = true})));
                   }});
    all.push_back({"gears", gears});
    for (const int cells : {3, 41, 129})
        all.push_back({fmt::format("sliding-{}", 12 * cells * cells), [=] { return sliding(cells); }});
    for (const bool shape : {false, true})
        all.push_back({shape ? "enclosed-shape" : "enclosed-mesh", [=] { return enclosed(shape); }});
    if (!files.nut.empty() && !files.bolt.empty()) all.push_back({"nut", [=] { return nut_and_bolt(files); }});
    std::ranges::move(shape_scenes(bodies), std::back_inserter(all));
    return all;
}

} // namespace

std::vector<ContactEntry> contact_scenes(const std::vector<std::string>& names, const ContactFiles& files, int bodies)
{
    std::vector<ContactEntry> all = entries(files, bodies);
    std::string valid;
    for (const ContactEntry& e : all) valid += (valid.empty() ? "" : ", ") + e.name;
    for (const std::string& name : names)
        if (std::ranges::find(all, name, &ContactEntry::name) == all.end())
            throw Error(ErrorKind::usage, fmt::format("--scene: no scene named '{}'; there are: {}", name, valid));
    if (!names.empty())
        std::erase_if(all, [&](const ContactEntry& e) { return std::ranges::find(names, e.name) == names.end(); });
    return all;
}

} // namespace oncollide::tools
