#include "bench/gpu/octant_levels.hpp"

#include <array>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/files/paths.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::tools {
namespace {

/// True if the triangle meets the closed box around the origin. Akenine-Möller's thirteen axes, in double.
bool meets(const std::array<Eigen::Vector3d, 3>& p, const Eigen::Vector3d& half)
{
    const auto apart = [&](const Eigen::Vector3d& axis) {
        const double a = axis.dot(p[0]), b = axis.dot(p[1]), c = axis.dot(p[2]), r = axis.cwiseAbs().dot(half);
        return std::min({a, b, c}) > r || std::max({a, b, c}) < -r;
    };
    for (int i = 0; i < 3; ++i)
        if (apart(Eigen::Vector3d::Unit(i))) return false;
    if (apart((p[1] - p[0]).cross(p[2] - p[0]))) return false;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            if (apart(Eigen::Vector3d::Unit(i).cross(p[(k + 1) % 3] - p[k]))) return false;
    return true;
}

} // namespace

void OctantLevels::find_truth(Cell& cell, const std::vector<std::vector<std::uint32_t>>& triangles) const
{
    cell.truth = 0;
    for (unsigned k = 0; k < 8; ++k) {
        const CellKey octant = child_cell(cell.key, k);
        const auto at = centre_of(octant);
        Eigen::Vector3d centre, half;
        for (int axis = 0; axis < 3; ++axis) {
            half[axis] = std::ldexp(double(root_.half[axis]), -level_of(octant));
            centre[axis] = root_.centre[axis] + at[axis] * half[axis];
        }
        for (std::uint32_t t : triangles[k]) {
            std::array<Eigen::Vector3d, 3> p;
            for (int i = 0; i < 3; ++i) p[i] = mesh().vertices[mesh().triangles[t][i]] - centre;
            if (!meets(p, half)) continue;
            cell.truth |= static_cast<std::uint8_t>(1u << k);
            break;
        }
    }
}

OctantLevels::OctantLevels(const Mesh& mesh, int depth) : mesh_(mesh), root_(root_cell_around(mesh.bounds))
{
    const auto backend = make_cpu_backend();
    backend->attach(0, surface());
    Ocst tree(root_, depth + 1, 0); // one level deeper, so that the lists of the last level are kept
    levels_.push_back({{root_cell, 0}});
    for (int level = 0; level < depth; ++level) {
        std::vector<OctantRow> rows;
        for (const Cell& cell : levels_.back()) rows.push_back(tree.row(0, cell.key));
        std::vector<OctantResult> results(rows.size());
        backend->run(rows, 1, results);
        std::vector<Cell> next;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            Cell& cell = levels_.back()[i];
            std::vector<std::vector<std::uint32_t>> triangles(8);
            std::vector<std::size_t> ends;
            for (unsigned k = 0; k < 8; ++k)
                backend->read(std::vector<ListRead>{{0, results[i].list, k}}, triangles[k], ends);
            find_truth(cell, triangles);
            tree.expand(cell.key, results[i], 1);
            for (unsigned k = 0; k < 8; ++k)
                if (cell.truth >> k & 1) next.push_back({child_cell(cell.key, k), 0});
        }
        if (level + 1 < depth) levels_.push_back(std::move(next));
    }
}

NamedMesh mesh_or_knot(const std::filesystem::path& data, const std::string& file, int triangles)
{
    const std::filesystem::path path = data / "meshes" / file;
    if (!data.empty() && is_regular(path)) return {path.stem().string(), load_mesh(path)};
    return {fmt::format("knot {}", triangles), make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, triangles)};
}

} // namespace oncollide::tools
