// The scenes of BENCHMARKS: the paper's own animation, many meshes, many boxes. Their numbers must not change: results
// are compared with other programs' results on the same scenes.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/catalogue_scenes.hpp>

namespace oncollide {

namespace {

/// Replacements with as many triangles as the models.
Json bunny_like(int triangles)
{
    return {{"kind", "sphere"}, {"radius", 1}, {"triangles", triangles}};
}
Json knot_like(int p, int q, int triangles)
{
    return {{"kind", "torus_knot"},  {"p", p}, {"q", q}, {"major", 1}, {"minor", 0.4}, {"tube", 0.18},
            {"triangles", triangles}};
}
Json ring_like(int triangles)
{
    return {{"kind", "torus"}, {"major", 1}, {"minor", 0.25}, {"triangles", triangles}};
}

/// One key per frame, so that every frame has the pose of the formula.
Keyed bunny_path()
{
    constexpr int frames = 2400;
    constexpr double pi = std::numbers::pi;
    const Eigen::Vector3d axis = Eigen::Vector3d::Ones() / std::sqrt(3.0);
    Keyed path;
    path.keys.reserve(frames);
    for (int f = 0; f < frames; ++f) {
        const double t = f / double(frames - 1);
        const Eigen::Vector3d position(-4 + 8 * t, 0.9 * std::cos(10 * pi * t), 0.45 * std::sin(10 * pi * t));
        path.keys.push_back({double(f), position, Eigen::Quaterniond(Eigen::AngleAxisd(8 * pi * t, axis))});
    }
    return path;
}

/// Geometries bunny, dragon, cow.
struct Models {
    GeometryId bunny, dragon, cow;
};

Models add_large_models(SceneBuilder& scene, const CatalogueOptions& options)
{
    return {add_model(scene, options, "bunny", "bunny_5110.obj", bunny_like(5110)),
            add_model(scene, options, "dragon", "dragon_5104.obj", knot_like(3, 4, 5082)),
            add_model(scene, options, "cow", "cow_5144.obj", knot_like(2, 3, 5144))};
}

void fill_paper_scene(SceneBuilder& scene, const Models& models, const CatalogueOptions& options)
{
    const GeometryId lamp = add_model(scene, options, "lamp", "lamp.obj", ring_like(600));
    scene.add_body({.name = "dragon", .geometry = models.dragon, .pose = placed({-2.5, 0, 0}), .is_static = true});
    scene.add_body({.name = "cow", .geometry = models.cow, .is_static = true});
    scene.add_body({.name = "lamp", .geometry = lamp, .pose = placed({2.5, 0, 0}), .is_static = true});
    const Motion path = bunny_path();
    scene.add_body({.name = "bunny",
                    .geometry = models.bunny,
                    .pose = pose_at(path, Eigen::Isometry3d::Identity(), 0),
                    .motion = path});
}

Aabb cube(double side)
{
    return {.min = Eigen::Vector3d::Zero(), .max = Eigen::Vector3d::Constant(side)};
}

} // namespace

void make_paper_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    const Models models{add_model(scene, options, "bunny", "bunny.obj", bunny_like(1500)),
                        add_model(scene, options, "dragon", "dragon.obj", knot_like(3, 4, 1496)),
                        add_model(scene, options, "cow", "cow.obj", knot_like(2, 3, 1500))};
    fill_paper_scene(scene, models, options);
}

void make_paper_5k_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    const Models models = add_large_models(scene, options);
    fill_paper_scene(scene, models, options);
}

void make_many_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    const Models models = add_large_models(scene, options);
    const GeometryId kinds[] = {models.bunny, models.dragon, models.cow};
    const Aabb walls = cube(std::cbrt(3.0 * *options.bodies));
    for (int i = 0; i < *options.bodies; ++i) {
        if (scene.skip_body()) continue;
        Dice dice(options.seed, static_cast<std::uint64_t>(i));
        const GeometryId kind = kinds[i % 3];
        const Eigen::Vector3d position = walls.centre() + dice.within(walls.half_extent());
        const Eigen::Quaterniond rotation = dice.rotation();
        const Eigen::Vector3d velocity = dice.within(Eigen::Vector3d::Constant(0.02));
        const double rate = dice.between(-0.05, 0.05);
        scene.add_body({.name = fmt::format("{}-{}", scene.geometries()[index(kind)].name, i),
                        .geometry = kind,
                        .pose = placed(position, rotation),
                        .motion = Drift{velocity, rate * dice.direction(), walls}});
    }
}

void make_boxes_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    const std::uint64_t s = options.seed;
    const Aabb walls = cube(std::cbrt(4.0 * *options.bodies));
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(*options.bodies); ++i) {
        Eigen::Vector3d half, position;
        for (std::uint64_t axis = 0; axis < 3; ++axis) {
            half[Eigen::Index(axis)] = 0.5 * (0.5 + u01(s, i, axis));
            position[Eigen::Index(axis)] = walls.max[Eigen::Index(axis)] * u01(s, i, 10 + axis);
        }
        const std::string name = fmt::format("box-{}", i);
        const GeometryId box = scene.add(name, Box{half});
        scene.add_body({.name = name,
                        .geometry = box,
                        .pose = placed(position),
                        .motion = Jitter{.step = 0.2, .seed = s + 1000, .index = i, .walls = walls}});
    }
}

} // namespace oncollide
