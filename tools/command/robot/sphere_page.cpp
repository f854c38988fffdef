// The page of `oncollide spheres --judge --html`.
#include "robot/sphere_page.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/svg.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>

#include "cli/log.hpp"
#include "cli/system.hpp"
#include "common/page_parts.hpp"
#include "common/text.hpp"
#include "render/png.hpp"

namespace oncollide::tools {
namespace {

using Corners = LinkSurface::Corners;

constexpr int panel_side = 360; ///< pixels, of each of the two panels
constexpr double sphere_view_angle = 0.35;
constexpr Colour covered_colour{170, 185, 200}, uncovered_colour{240, 130, 30}, bubble{60, 120, 200, 110},
    mark{200, 0, 40};

bool meets(const CoverSphere& sphere, const Corners& triangle)
{
    return (nearest_on(triangle, sphere.centre).at - sphere.centre).norm() <= sphere.radius;
}

bool holds(const CoverSphere& sphere, const Eigen::Vector3d& point)
{
    return (point - sphere.centre).norm() <= sphere.radius;
}

void divide_triangle(const Corners& triangle, const std::vector<CoverSphere>& near, double edge, DividedSurface& to)
{
    std::vector<CoverSphere> mine;
    for (const CoverSphere& sphere : near) {
        if (std::ranges::all_of(triangle, [&](const auto& corner) { return holds(sphere, corner); }))
            return to.covered.push_back(triangle);
        if (meets(sphere, triangle)) mine.push_back(sphere);
    }
    if (mine.empty()) return to.uncovered.push_back(triangle);
    if (longest_edge(triangle) < edge) {
        const Eigen::Vector3d middle = (triangle[0] + triangle[1] + triangle[2]) / 3;
        const bool in = std::ranges::any_of(mine, [&](const CoverSphere& sphere) { return holds(sphere, middle); });
        return (in ? to.covered : to.uncovered).push_back(triangle);
    }
    for (const Corners& half : halves_of(triangle)) divide_triangle(half, mine, edge, to);
}

Mesh mesh_of(const std::vector<Corners>& corners)
{
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (const Corners& one : corners) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        vertices.insert(vertices.end(), one.begin(), one.end());
        triangles.push_back({first, first + 1, first + 2});
    }
    return make_mesh("surface", std::move(vertices), std::move(triangles));
}

bool has_mark(const JudgedLink& link)
{
    return link.judged.gap > 0 && std::isfinite(link.judged.gap);
}

/// Draws the link from the side of its worst gap; on the right with its spheres.
std::string draw(PainterProcess& painter, const JudgedLink& link)
{
    Aabb box;
    for (const Corners& triangle : link.surface->triangles())
        for (const Eigen::Vector3d& corner : triangle) box.add(corner);
    const DividedSurface parts = divide(*link.surface, link.spheres, box.diagonal() / 200);
    std::optional<Mesh> covered, uncovered;
    Picture picture;
    const auto add = [&](std::optional<Mesh>& mesh, const std::vector<Corners>& triangles, Colour colour) {
        if (triangles.empty()) return;
        mesh = mesh_of(triangles);
        picture.bodies.push_back({&*mesh, Eigen::Isometry3d::Identity(), colour});
    };
    add(covered, parts.covered, covered_colour), add(uncovered, parts.uncovered, uncovered_colour);
    for (const CoverSphere& sphere : link.spheres)
        box.add(sphere.centre - Eigen::Vector3d::Constant(sphere.radius)),
            box.add(sphere.centre + Eigen::Vector3d::Constant(sphere.radius));
    Eigen::Vector3d from(0.45, -1, 0.45);
    if (has_mark(link)) {
        const Eigen::Vector3d& at = link.judged.worst;
        const CoverSphere& nearest = *std::ranges::min_element(
            link.spheres, {}, [&](const CoverSphere& s) { return (at - s.centre).norm() - s.radius; });
        const Eigen::Vector3d on = nearest.centre + nearest.radius * (at - nearest.centre).normalized();
        picture.lines = {{at, on, 2, mark}, {at, at, 9, mark}};
        if ((at - box.centre()).norm() > 0) from = at - box.centre();
        from = from.normalized() + Eigen::Vector3d(0.3, -0.3, 0.3); // turns the view away from the gap
    }
    picture.width = picture.height = panel_side;
    picture.camera = {.eye =
                          box.centre() + from.normalized() * (0.5 * box.diagonal() / std::sin(0.5 * sphere_view_angle)),
                      .look_at = box.centre(),
                      .view_angle = sphere_view_angle};
    Image image = blank(2 * panel_side, panel_side);
    paste(painter.draw(picture), panel_side, image, 0);
    for (const CoverSphere& sphere : link.spheres) picture.balls.push_back({sphere.centre, sphere.radius, bubble});
    paste(painter.draw(picture), panel_side, image, panel_side);
    return packed_png(image);
}

std::string caption(const JudgedLink& link)
{
    const CoverJudgement& j = link.judged;
    const std::string spheres =
        fmt::format("{} {}", link.spheres.size(), link.spheres.size() == 1 ? "sphere" : "spheres");
    if (j.complete) return fmt::format("{}: {} contain all of the surface.", link.name, spheres);
    const std::string open =
        fmt::format("{:.1f} to {:.1f} % of the surface", 100 * j.uncovered / j.area, 100 * j.uncovered_most / j.area);
    if (!has_mark(link)) return fmt::format("{}: {}; {} is in none.", link.name, spheres, open);
    return fmt::format("{}: {}; {} is in none. Worst gap {:.1f} mm at {:.3f} {:.3f} {:.3f} (red).", link.name, spheres,
                       open, 1e3 * j.gap, j.worst.x(), j.worst.y(), j.worst.z());
}

} // namespace

DividedSurface divide(const LinkSurface& surface, std::span<const CoverSphere> spheres, double edge)
{
    DividedSurface parts;
    for (const Corners& triangle : surface.triangles())
        divide_triangle(triangle, {spheres.begin(), spheres.end()}, edge, parts);
    return parts;
}

std::string write_sphere_page(const std::string& path, const std::string& title, const std::string& table,
                              std::span<const JudgedLink> links, PainterProcess& painter)
{
    OutputFile file(path);
    begin_page(file, title, command_text());
    file.print("<pre>{}</pre>\n", xml_escaped(table));
    heading(file, "Links");
    paragraph(file, "Orange: the surface outside all spheres. Red: the worst gap, from the surface to the nearest "
                    "sphere. On the right the same with the spheres.");
    std::string missing;
    std::size_t drawn = 0;
    for (const JudgedLink& link : links) {
        std::string png;
        try {
            if (missing.empty()) png = draw(painter, link), ++drawn;
        } catch (const Error& error) {
            if (error.kind() != ErrorKind::no_gpu) throw;
            missing = fmt::format("{}ictures: {}", drawn ? "Not all p" : "No p", error.what());
            paragraph(file, missing);
        }
        png.empty() ? paragraph(file, caption(link)) : show_picture(file, {caption(link), png});
    }
    end_page(file, describe_program("spheres"));
    file.commit();
    return missing;
}

} // namespace oncollide::tools
