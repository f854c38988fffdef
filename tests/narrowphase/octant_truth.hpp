// The truth about octants, by clipping in double, and inputs and tree growth that the tests of backends share.
#pragma once
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/narrowphase/spheres/ocst.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

#include "narrowphase/geometry_surface.hpp"

namespace oncollide {

using Polygon = std::vector<Eigen::Vector3d>;

/// The part of a polygon on the side n . x <= d (Sutherland and Hodgman).
inline Polygon clip(const Polygon& in, int axis, double sign, double d)
{
    Polygon out;
    for (std::size_t i = 0; i < in.size(); ++i) {
        const Eigen::Vector3d &p = in[i], &q = in[(i + 1) % in.size()];
        const double sp = sign * p[axis] - d, sq = sign * q[axis] - d;
        if (sp <= 0) out.push_back(p);
        if ((sp < 0 && sq > 0) || (sp > 0 && sq < 0)) out.push_back(p + (q - p) * (sp / (sp - sq)));
    }
    return out;
}

/// Whether the triangle enters the box grown by `grow`. Uses clipping in double, independent of the test's separating
/// axes.
inline bool enters(const Mesh& mesh, const Triangle& t, const Eigen::Vector3d& centre, const Eigen::Vector3d& half,
                   double grow)
{
    Polygon polygon{mesh.vertices[t[0]] - centre, mesh.vertices[t[1]] - centre, mesh.vertices[t[2]] - centre};
    for (int axis = 0; axis < 3 && !polygon.empty(); ++axis)
        for (double sign : {1.0, -1.0}) polygon = clip(polygon, axis, sign, half[axis] + grow);
    return !polygon.empty();
}

struct Case {
    std::string name;
    Mesh mesh;
};

inline Mesh moved(Mesh mesh, double scale, const Eigen::Vector3d& by)
{
    return transformed("moved", std::move(mesh), scale, -by / scale);
}

inline std::vector<Case> cases()
{
    std::vector<Case> all;
    // Real meshes, if there is a data folder beside the sources.
    const char* data = std::getenv("ONCOLLIDE_DATA");
    const std::filesystem::path folder = data ? data : ONCOLLIDE_SOURCE_DIR "/../shared/data";
    for (const char* file : {"meshes/paper/lamp.obj", "meshes/woody.obj"})
        if (std::filesystem::exists(folder / file)) all.push_back({file, load_mesh(folder / file)});
    all.push_back({"knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 1500)});
    all.push_back({"gear", make_gear_mesh(12, 1, 1.3, 0.4, 0.3)});
    all.push_back({"terrain", make_terrain_mesh(10, 2, 16, 3)});
    all.push_back({"needles", make_needles_mesh(300, 1, 1e5, 3, 7)});
    all.push_back({"thin needles", make_needles_mesh(300, 1, 1e12, 3, 8)});
    all.push_back({"tiny triangles", make_soup_mesh(400, 1e-5, 3, 9)});
    all.push_back({"soup", make_soup_mesh(300, 0.7, 3, 10)});
    all.push_back({"box: axis-aligned faces on cell faces", make_box_mesh({1, 1, 1})});
    all.push_back(
        {"flat", make_mesh("flat", {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {{0, 1, 2}, {0, 2, 3}})});
    all.push_back({"one zero-area triangle", make_mesh("line", {{0, 0, 0}, {1, 2, 3}, {2, 4, 6}}, {{0, 1, 2}})});
    all.push_back({"knot at 1e6", moved(make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 800), 1, {1e6, -1e6, 1e6})});
    all.push_back({"soup of size 1e-6", moved(make_soup_mesh(200, 0.5, 3, 11), 1e-6, {0, 0, 0})});
    all.push_back({"soup of size 1e6", moved(make_soup_mesh(200, 0.5, 3, 12), 1e6, {0, 0, 0})});
    return all;
}

/// Whether the triangle enters the cell grown by `grow`.
inline bool enters(const Mesh& mesh, const Triangle& t, const RootCell& root, CellKey cell, double grow)
{
    const auto at = centre_of(cell);
    Eigen::Vector3d centre, half;
    for (int axis = 0; axis < 3; ++axis) {
        half[axis] = std::ldexp(double(root.half[axis]), -level_of(cell));
        centre[axis] = root.centre[axis] + at[axis] * half[axis];
    }
    return enters(mesh, t, centre, half, grow);
}

/// The octants of the cell, each grown by `grow`, that the mesh enters.
inline unsigned octants_entered(const Mesh& mesh, const RootCell& root, CellKey cell, double grow)
{
    unsigned entered = 0;
    for (unsigned k = 0; k < 8; ++k)
        for (const Triangle& t : mesh.triangles)
            if (enters(mesh, t, root, child_cell(cell, k), grow)) {
                entered |= 1u << k;
                break;
            }
    return entered;
}

/// Grows the whole tree of `mesh`, number 0, level by level: visit(root, cell, grey) receives the result for each cell
/// and returns the octants to expand.
template <class Visit>
Ocst grow(OcclusionBackend& backend, const Mesh& mesh, int depth, Visit visit)
{
    const Geometry geometry{"mesh", mesh, {}};
    const RootCell root = root_cell_of(geometry);
    Ocst tree(root, depth, 0);
    backend.attach(0, make_surface(geometry, root));
    std::vector<CellKey> level{root_cell};
    while (!level.empty()) {
        std::vector<OctantRow> rows;
        for (CellKey cell : level) rows.push_back(tree.row(0, cell));
        std::vector<OctantResult> answers(rows.size());
        backend.run(rows, 2, answers);
        std::vector<CellKey> next;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const unsigned follow = visit(root, level[i], unsigned(answers[i].grey));
            tree.expand(level[i], {static_cast<std::uint8_t>(follow), answers[i].list}, 1);
            for (unsigned k = 0; k < 8; ++k)
                if (follow >> k & 1 && level_of(level[i]) + 1 < depth) next.push_back(child_cell(level[i], k));
        }
        level = next;
    }
    return tree;
}

} // namespace oncollide
