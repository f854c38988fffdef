// Flags in the wind, which reach statues and balls in some frames.
#include <array>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/samples/catalogue_scenes.hpp>

namespace oncollide {

namespace {

constexpr double flag_length = 1.5, flag_width = 1, pole_height = 2, between_poles = 4; ///< metres
constexpr int flag_kinds = 5;

/// Waves from the pole, and a gust that swings the whole flag.
Json wind(const CatalogueOptions& options, int kind)
{
    Dice dice(options.seed, std::uint64_t(1) << 40 | std::uint64_t(kind));
    const auto wave = [&](double angle, double length, double period) {
        return Json{angle, length * dice.between(0.8, 1.25), std::round(period * dice.between(0.8, 1.25)),
                    dice.between(-0.2, 0.2), dice.next()};
    };
    return {{"edge", {-flag_length / 2, 0, 0}},
            {"along", {1, 0, 0}},
            {"normal", {0, 0, 1}},
            {"growth", 0.4},
            {"waves", {wave(0.8, 15, 110), wave(0.6, 1.2, 26), wave(0.25, 0.5, 12)}}};
}

} // namespace

void make_flags_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    std::array<GeometryId, flag_kinds> flags;
    for (int kind = 0; kind < flag_kinds; ++kind)
        flags[std::size_t(kind)] = add_geometry(
            scene, fmt::format("flag {}", kind),
            {{"mesh", {{"generate", {{"kind", "sheet"}, {"size", {flag_length, flag_width}}, {"cells", {30, 20}}}}}},
             {"deformation", {{"flutter", wind(options, kind)}}}});
    const GeometryId pole = scene.add("pole", Cylinder{.radius = 0.04, .length = pole_height}),
                     statue = add_knot(scene, "statue", 2, 2000), ball = scene.add("ball", Sphere{0.15});
    Eigen::Matrix3d upright; // its length along x, its width along z
    upright << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    const std::uint32_t wide = static_cast<std::uint32_t>(std::ceil(std::sqrt(*options.bodies / 4.0)));
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(*options.bodies); ++i) {
        if (scene.skip_body()) continue;
        const std::uint32_t place = i / 4;
        const Eigen::Vector3d at(between_poles * (place % wide), between_poles * (place / wide), 0);
        const Eigen::Vector3d middle = at + Eigen::Vector3d(flag_length / 2, 0, pole_height - flag_width / 2);
        Dice dice(options.seed, i);
        BodyInit body;
        if (i % 4 == 0) { // it does not collide with its own pole
            body = {.name = "flag", .geometry = flags[place % flag_kinds], .group = place + 1};
            body.pose = placed(middle, Eigen::Quaterniond(upright));
        } else if (i % 4 == 1) {
            body = {.name = "pole", .geometry = pole, .is_static = true, .group = place + 1};
            body.pose = placed(at + Eigen::Vector3d(0, 0, pole_height / 2));
        } else if (i % 4 == 2) {
            body = {.name = "statue", .geometry = statue, .is_static = true};
            const double turn = dice.between(0, 3), aside = dice.between(0.9, 1.5);
            body.pose = placed(at + Eigen::Vector3d(1.2, aside, 0.8),
                               Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ())));
        } else {
            const Eigen::Vector3d half(0.9, 1.2, 0.4);
            body = {.name = "ball", .geometry = ball};
            body.pose = placed(middle + dice.within(half));
            body.motion = Drift{.velocity = dice.within({0.02, 0.05, 0.02}), .walls = {middle - half, middle + half}};
        }
        body.name += fmt::format("-{}", place);
        scene.add_body(std::move(body));
    }
}

} // namespace oncollide
