// Random scenes, to find unexpected cases: every kind of geometry, sizes over orders of magnitude, near and far from
// the origin, static and moving, on layers.
#include <cmath>

#include <fmt/format.h>

#include <oncollide/samples/catalogue_scenes.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// Low * (high / low)^u: a log-uniform distribution.
double spread(Dice& dice, double low, double high)
{
    return low * std::pow(high / low, dice.next());
}

int whole(Dice& dice, int low, int high) // both included
{
    return low + static_cast<int>(dice.next() * (high - low + 1));
}

// Draws stand in statements of their own where compilers differ in the order in which they evaluate arguments.

Vector3d random_extents(Dice& dice)
{
    const double z = dice.between(0.05, 1), y = dice.between(0.05, 1), x = dice.between(0.05, 1);
    return {x, y, z};
}

/// One of the mesh generators with random parameters, about `size` across.
Json random_generator(Dice& dice, double size, std::uint64_t seed)
{
    switch (whole(dice, 0, 7)) {
    case 0: {
        const Vector3d half = 0.5 * size * random_extents(dice);
        return {{"kind", "box"}, {"half", {half.x(), half.y(), half.z()}}};
    }
    case 1:
        return {{"kind", "sphere"}, {"radius", 0.5 * size}, {"triangles", whole(dice, 8, 3000)}};
    case 2:
        return {{"kind", "torus"},
                {"major", 0.4 * size},
                {"minor", size * dice.between(0.02, 0.2)},
                {"triangles", whole(dice, 18, 3000)}};
    case 3:
        return {{"kind", "torus_knot"},
                {"p", 2},
                {"q", 2 * whole(dice, 1, 4) + 1},
                {"major", 0.4 * size},
                {"minor", 0.15 * size},
                {"tube", size * dice.between(0.02, 0.08)},
                {"triangles", whole(dice, 200, 3000)}};
    case 4:
        return {{"kind", "gear"},
                {"teeth", whole(dice, 3, 30)},
                {"root_radius", 0.4 * size},
                {"tip_radius", 0.5 * size},
                {"thickness", size * dice.between(0.02, 0.5)},
                {"bore_radius", 0.1 * size}};
    case 5:
        return {{"kind", "terrain"},
                {"size", size},
                {"height", size * dice.between(0.01, 0.5)},
                {"cells", whole(dice, 2, 30)},
                {"seed", seed}};
    case 6:
        return {{"kind", "needles"},    {"count", whole(dice, 1, 300)},
                {"length", 0.5 * size}, {"aspect", spread(dice, 3, 1e5)},
                {"size", size},         {"seed", seed}};
    default:
        return {{"kind", "soup"},
                {"count", whole(dice, 1, 600)},
                {"edge", size * dice.between(0.05, 0.5)},
                {"size", size},
                {"seed", seed}};
    }
}

Shape random_shape(Dice& dice, double size)
{
    switch (whole(dice, 0, 4)) {
    case 0:
        return Sphere{0.5 * size};
    case 1:
        return Box{0.5 * size * random_extents(dice)};
    case 2:
        return Capsule{size * dice.between(0.05, 0.4), size * dice.between(0.1, 1)};
    case 3:
        return Cylinder{size * dice.between(0.05, 0.5), size * dice.between(0.1, 1)};
    default:
        break;
    }
    ConvexHull hull;
    const int points = whole(dice, 6, 40);
    for (int i = 0; i < points; ++i) hull.points.push_back(0.5 * size * dice.direction());
    return hull;
}

GeometryId random_geometry(SceneBuilder& scene, Dice& dice, double size, std::uint64_t seed)
{
    const std::string name = fmt::format("geometry-{}", scene.geometries().size());
    const double lot = dice.next();
    if (lot < 0.08 && size > 0.2 && size < 20) // a room is 4 m wide, independent of the scene's size
        return add_geometry(
            scene, name,
            {{"octomap", {{"building", {{"rooms", 1}, {"resolution", dice.between(0.1, 0.5)}, {"seed", seed}}}}}});
    if (lot < 0.36) return scene.add(name, random_shape(dice, size));
    return add_geometry(scene, name, {{"mesh", {{"generate", random_generator(dice, size, seed)}}}});
}

} // namespace

void make_random_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    Dice dice(options.seed, 0);
    const double scale = spread(dice, 0.01, 100);
    const bool layered = dice.next() < 0.4;
    const Vector3d origin = dice.next() < 0.3 ? Vector3d(scale * 1e6 * dice.direction()) : Vector3d::Zero();

    std::vector<GeometryId> geometries;
    const int kinds = whole(dice, 2, 6);
    double volume = 0; // of the bodies' boxes
    for (int k = 0; k < kinds; ++k) {
        Dice own(options.seed, 1'000'000 + static_cast<std::uint64_t>(k));
        geometries.push_back(random_geometry(scene, own, scale * spread(own, 0.2, 4), options.seed + std::uint64_t(k)));
        volume += bounds_of(scene.geometries().back()).volume() * *options.bodies / kinds;
    }
    // Boxes fill the cube about once: most bodies have a neighbour, few have many.
    const double side = std::cbrt(volume * spread(dice, 0.5, 4)) + scale;
    const Aabb walls{origin - Vector3d::Constant(0.5 * side), origin + Vector3d::Constant(0.5 * side)};
    for (int i = 0; i < *options.bodies; ++i) {
        if (scene.skip_body()) continue;
        Dice own(options.seed, 2'000'000 + static_cast<std::uint64_t>(i));
        BodyInit body{.name = fmt::format("body-{}", i), .geometry = geometries[std::size_t(whole(own, 0, kinds - 1))]};
        const Eigen::Quaterniond rotation = own.rotation();
        body.pose = placed(origin + own.within(walls.half_extent()), rotation);
        body.is_static = own.next() < 0.25;
        if (!body.is_static)
            body.motion =
                Drift{own.within(Vector3d::Constant(0.05 * scale)), own.within(Vector3d::Constant(0.2)), walls};
        if (layered) {
            body.layer = 1u << whole(own, 0, 2);
            body.mask = static_cast<std::uint32_t>(whole(own, 1, 7));
        }
        scene.add_body(std::move(body));
    }
}

} // namespace oncollide
