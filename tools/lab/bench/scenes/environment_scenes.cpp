#include "bench/scenes/environment_scenes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/ranges.h>

#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/samples/bodies_above.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::tools {

namespace {

/// The environment's file in the data folder; empty: it is generated.
std::filesystem::path file_of(const EnvironmentScene& which)
{
    const char* place = which.environment == "campus"      ? "octomap/fr_campus.bt"
                        : which.environment == "st-helens" ? "terrain/SainteHelens.dem"
                                                           : nullptr;
    if (!place) return {};
    if (which.data.empty())
        usage(fmt::format("environment '{}': needs the data folder; give --data or set ONCOLLIDE_DATA",
                          which.environment));
    return which.data / place;
}

/// Shapes of about one metre, by kind.
const std::vector<std::pair<std::string, Shape>>& every_shape()
{
    static const std::vector<std::pair<std::string, Shape>> shapes = [] {
        ConvexHull hull;
        for (int k = 0; k < 24; ++k) { // on a spiral over an ellipsoid
            const double z = (2 * k + 1) / 24.0 - 1, across = std::sqrt(1 - z * z);
            hull.points.push_back({0.4 * across * std::cos(2.4 * k), 0.6 * across * std::sin(2.4 * k), 0.8 * z});
        }
        return std::vector<std::pair<std::string, Shape>>{
            {"sphere", Sphere{0.5}},        {"box", Box{{0.4, 0.7, 1}}}, {"capsule", Capsule{0.3, 1.2}},
            {"cylinder", Cylinder{0.4, 1}}, {"hull", std::move(hull)},   {"ellipsoid", Ellipsoid{{0.3, 0.5, 0.9}}},
            {"cone", Cone{0.5, 1}}};
    }();
    return shapes;
}

GeometryData environment_of(const EnvironmentScene& which)
{
    for (const auto& [kind, shape] : every_shape())
        if (which.environment == kind) return shape;
    const std::string& name = which.environment;
    const double relief = 0.1 * which.cells;
    const auto cells = static_cast<std::uint32_t>(which.cells);
    if (name == "building") return make_building_map(30, 0.06, which.seed);
    if (name == "hills") return make_hills(cells, cells, 1, relief, which.seed);
    if (name == "hills-mesh") return mesh_of(make_hills(cells, cells, 1, relief, which.seed));
    if (name == "campus") return load_octomap(file_of(which));
    return load_terrain(file_of(which));
}

std::vector<GeometryId> add_bodies_of(Scene& scene, const std::string& kind)
{
    std::vector<GeometryId> ids;
    if (kind == "meshes" || kind == "both") ids = add_meshes_of_a_metre(scene);
    if (kind == "meshes") return ids;
    for (std::size_t k = 0; k < (kind == "all-shapes" ? every_shape().size() : 3); ++k)
        ids.push_back(scene.add(every_shape()[k].first, every_shape()[k].second));
    return ids;
}

} // namespace

const std::vector<std::string>& environment_names()
{
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all{"building", "hills", "hills-mesh", "campus", "st-helens"};
        for (const auto& [kind, shape] : every_shape()) all.push_back(kind);
        return all;
    }();
    return names;
}

void check(const EnvironmentScene& which)
{
    const auto& names = environment_names();
    if (std::ranges::count(names, which.environment) == 0)
        usage(fmt::format("--environments {}: valid are {}", which.environment, fmt::join(names, ", ")));
    const std::array<std::string_view, 4> bodies{"meshes", "shapes", "both", "all-shapes"};
    if (std::ranges::count(bodies, which.bodies_of) == 0)
        usage(fmt::format("--bodies-of {}: valid are {}", which.bodies_of, fmt::join(bodies, ", ")));
    if (const std::filesystem::path file = file_of(which); !file.empty()) check_readable(file);
}

std::string EnvironmentChoice::work() const
{
    return fmt::format("{} with {} {}, {} cells, seed {}", environments, bodies, bodies_of, cells, seed);
}

std::vector<EnvironmentScene> scenes_of(const EnvironmentChoice& choice, int frames)
{
    std::vector<EnvironmentScene> scenes;
    for (const std::string& environment : split(choice.environments))
        for (const std::string& bodies_of : split(choice.bodies_of))
            scenes.push_back(
                {environment, bodies_of, choice.bodies, frames, choice.cells, choice.seed, data_folder(choice.data)});
    for (const EnvironmentScene& which : scenes) check(which);
    return scenes;
}

Scene make_environment_scene(const EnvironmentScene& which)
{
    check(which);
    Scene scene;
    scene.name = which.environment + ", " + which.bodies_of;
    scene.frames = which.frames;
    GeometryData environment = environment_of(which);
    const std::vector<Eigen::Vector3d> points = surface_points(environment);
    const Aabb bounds = bounds_of(environment);
    scene.add_body(
        {.name = which.environment, .geometry = scene.add("environment", std::move(environment)), .is_static = true});
    add_bodies_above(scene, points, bounds, add_bodies_of(scene, which.bodies_of), which.bodies, which.seed);
    return scene;
}

void add_environment_choice(BenchmarkCommand& sub, EnvironmentChoice& in, int most_bodies)
{
    sub.option("--environments LIST", in.environments,
               "environments (default building,hills,hills-mesh): building, a map of 30 x 30 rooms at 6 cm; hills, "
               "a height grid; hills-mesh, the same as a mesh; campus and st-helens, from the data folder; or one "
               "shape of about a metre: sphere, box, capsule, cylinder, hull, ellipsoid, cone");
    sub.option("--bodies-of LIST", in.bodies_of,
               "meshes, shapes (spheres, boxes and capsules), all-shapes (all bounded kinds), both, or a list "
               "(default meshes,shapes)");
    sub.whole("--bodies N", in.bodies, "bodies in each environment", {1, most_bodies});
    sub.whole("--cells N", in.cells, "cells along a side of the hills; 2200 give 9.7 million triangles", {8, 20'000});
    sub.option("--seed S", in.seed, "seed of environments and bodies (default 1)");
    sub.option("--data DIR", in.data, "data folder (default: $ONCOLLIDE_DATA, else ../shared/data if present)");
}

} // namespace oncollide::tools
