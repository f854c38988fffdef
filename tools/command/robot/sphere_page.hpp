#pragma once
#include <span>
#include <string>
#include <vector>

#include <oncollide/robots/spheres/sphere_judge.hpp>

#include "render/painter_process.hpp"

namespace oncollide::tools {

/// A link with the spheres of a model, and their judgement.
struct JudgedLink {
    std::string name;
    const LinkSurface* surface;
    std::span<const CoverSphere> spheres;
    CoverJudgement judged;
};

/// The surface, divided where a sphere cuts it, until edges are shorter than `edge`: triangles in spheres, and outside.
/// Triangles across a border go where their middle is.
struct DividedSurface {
    std::vector<LinkSurface::Corners> covered, uncovered;
};
DividedSurface divide(const LinkSurface& surface, std::span<const CoverSphere> spheres, double edge);

/// Writes a page with a table and a picture of each link: the surface outside all spheres orange, the worst gap marked.
/// @param table  lines of plain text
/// Returns why pictures are missing, as the page says, too; empty: none is.
std::string write_sphere_page(const std::string& path, const std::string& title, const std::string& table,
                              std::span<const JudgedLink> links, PainterProcess& painter);

} // namespace oncollide::tools
