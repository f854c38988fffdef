#include "self/self_pictures.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/runs/pipeline.hpp>

#include "render/drawn_mesh.hpp"
#include "render/flat_picture.hpp"
#include "render/framing.hpp"
#include "render/shading.hpp"
#include "view/view_page.hpp"

namespace oncollide::tools {
namespace {

constexpr int panel = 480;               ///< pixels
constexpr std::size_t most_places = 200; ///< with bodies of their own on a page

/// Sorted, each once.
std::vector<std::uint32_t> triangles_of(std::span<const SelfPlace> places, bool lower, bool higher)
{
    std::vector<std::uint32_t> all;
    for (const SelfPlace& place : places)
        for (const TrianglesThatMeet& pair : place.pairs) {
            if (lower) all.push_back(pair.a);
            if (higher) all.push_back(pair.b);
        }
    std::ranges::sort(all);
    all.erase(std::ranges::unique(all).begin(), all.end());
    return all;
}

std::vector<std::uint32_t> all_but(const std::vector<std::uint32_t>& triangles, const Mesh& mesh)
{
    std::vector<std::uint32_t> others;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        if (!std::ranges::binary_search(triangles, t)) others.push_back(t);
    return others;
}

std::ptrdiff_t red_pixels(const Image& image)
{
    std::ptrdiff_t count = 0;
    for (std::size_t k = 0; k < image.pixels.size(); k += 3) count += image.pixels[k] > 2 * image.pixels[k + 1];
    return count;
}

/// Draws the surroundings of a ball from the side that shows most red.
Image best_view(Picture picture, const Eigen::Vector3d& middle, double radius)
{
    std::ptrdiff_t most = 0;
    picture.width = picture.height = panel / 5;
    Camera best = camera_from(good_sides()[0], middle, radius);
    for (const Eigen::Vector3d& from : good_sides()) {
        picture.camera = camera_from(from, middle, radius);
        if (const std::ptrdiff_t red = red_pixels(draw_bodies(picture)); red > most) most = red, best = picture.camera;
    }
    picture.width = picture.height = panel, picture.camera = best;
    return draw_bodies(picture);
}

} // namespace

Image draw_self(const Mesh& mesh, const std::vector<SelfPlace>& places)
{
    const std::vector<std::uint32_t> meeting = triangles_of(places, true, true);
    const Mesh red = part_of(mesh, meeting), rest = part_of(mesh, all_but(meeting, mesh));
    Picture picture;
    for (const auto& [part, colour] : {std::pair{&red, touching}, {&rest, surface_colour(0)}})
        if (!part->triangles.empty()) picture.bodies.push_back({part, Eigen::Isometry3d::Identity(), colour});
    const double size = std::max(mesh.bounds.diagonal(), 1e-300);
    const Image whole = best_view(picture, mesh.bounds.centre(), 0.55 * size);
    if (places.empty()) return whole;

    const auto around = part_of(mesh, triangles_of({&places[0], 1}, true, true)).bounds;
    const double near = std::max(0.7 * around.diagonal(), 1e-6 * size);
    Image close = best_view(picture, places[0].box.centre(), near);
    if (red_pixels(close) == 0) { // the rest hides it from all sides
        picture.bodies.resize(1);
        close = best_view(picture, places[0].box.centre(), near);
    }
    Image both = blank(2 * panel, panel);
    paste(whole.pixels, panel, both, 0), paste(close.pixels, panel, both, panel);
    return both;
}

std::string write_self_view(const std::string& file, const std::string& name, const Mesh& mesh,
                            const std::vector<SelfPlace>& places, std::size_t most_bytes)
{
    Scene scene;
    scene.name = name;
    const auto add = [&](const std::string& name, const std::vector<std::uint32_t>& triangles, std::uint32_t layer,
                         std::uint32_t mask) {
        if (triangles.empty()) return;
        const GeometryId geometry = scene.add(name, part_of(mesh, triangles));
        scene.add_body({.name = name, .geometry = geometry, .layer = layer, .mask = mask});
    };
    add("mesh", all_but(triangles_of(places, true, true), mesh), 1, 0);
    const auto add_place = [&](const std::string& name, std::span<const SelfPlace> of) {
        add(name + ", one side", triangles_of(of, true, false), 2, 4);
        add(name + ", other side", triangles_of(of, false, true), 4, 2);
    };
    // Triangles of different places do not meet, so the pairs that collide are the places.
    const std::size_t alone = std::min(places.size(), most_places);
    for (std::size_t i = 0; i < alone; ++i) add_place(fmt::format("place {}", i + 1), {&places[i], 1});
    if (alone < places.size()) add_place("other places", std::span(places).subspan(alone));
    Pipeline pipeline(scene, {.exact = ExactLevel::predicates});
    ViewPage page(scene, pipeline, {.file = file, .most_bytes = most_bytes, .frames = 1});
    page.add(pipeline.step(scene));
    page.close();
    return page.summary();
}

} // namespace oncollide::tools
