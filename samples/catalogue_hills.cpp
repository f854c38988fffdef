// Shapes and meshes low over a terrain of generated hills.
#include <cmath>

#include <fmt/format.h>

#include <oncollide/samples/catalogue_scenes.hpp>

namespace oncollide {

void make_hills_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    constexpr std::uint32_t cells = 400;
    constexpr double spacing = 0.5;
    const GeometryId land = add_geometry(
        scene, "land",
        {{"terrain", {{"hills", {{"cells", cells}, {"spacing", spacing}, {"height", 20}, {"seed", options.seed}}}}}});
    scene.add_body({.name = "land", .geometry = land, .is_static = true});
    const auto mesh = [&](const char* name, Json generator) {
        return add_geometry(scene, name, {{"mesh", {{"generate", std::move(generator)}}}});
    };
    const GeometryId kinds[] = {
        scene.add("ball", Sphere{0.5}),
        mesh("knot", {{"kind", "torus_knot"},
                      {"p", 2},
                      {"q", 3},
                      {"major", 0.8},
                      {"minor", 0.3},
                      {"tube", 0.15},
                      {"triangles", 6000}}),
        scene.add("crate", Box{{0.6, 0.4, 0.3}}),
        mesh("ring", {{"kind", "torus"}, {"major", 0.6}, {"minor", 0.2}, {"triangles", 2000}}),
        scene.add("rod", Capsule{.radius = 0.2, .length = 1.2}),
    };
    const auto& heights = std::get<Terrain>(scene.geometries()[index(land)].data);
    Aabb walls = bounds_of(scene.geometries()[index(land)]);
    walls.max.z() += 2;
    for (int i = 0; i < *options.bodies; ++i) {
        if (scene.skip_body()) continue;
        Dice dice(options.seed, static_cast<std::uint64_t>(i));
        const GeometryId kind = kinds[i % 5];
        const double x = dice.between(1, cells * spacing - 1), y = dice.between(1, cells * spacing - 1);
        const double ground =
            heights.height(static_cast<std::uint32_t>(x / spacing), static_cast<std::uint32_t>(y / spacing));
        const Eigen::Vector3d position(x, y, ground + dice.between(-0.5, 1.5));
        const Eigen::Quaterniond rotation = dice.rotation();
        Drift drift{.velocity = dice.within({0.1, 0.1, 0.01}), .spin = 0.03 * dice.direction(), .walls = walls};
        scene.add_body({.name = fmt::format("{}-{}", scene.geometries()[index(kind)].name, i),
                        .geometry = kind,
                        .pose = placed(position, rotation),
                        .motion = drift});
    }
}

} // namespace oncollide
