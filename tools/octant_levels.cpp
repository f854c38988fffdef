#include "octant_levels.hpp"

#include <oncollide/scenes/mesh_file.hpp>
#include <oncollide/scenes/mesh_generators.hpp>

namespace oncollide::tools {

OctantLevels::OctantLevels(const Mesh& mesh, int depth) : geometry_{"mesh", mesh, {}}, root_(root_cell_of(geometry_))
{
    const auto backend = make_cpu_backend();
    backend->attach(0, surface());
    Ocst tree(root_, depth, 0);
    cells_.push_back({root_cell});
    std::vector<OctantRow> rows;
    std::vector<OctantAnswer> answers;
    for (int level = 0; level + 1 < depth; ++level) {
        rows.clear();
        for (CellKey cell : cells_.back()) rows.push_back(tree.row(0, cell));
        answers.resize(rows.size());
        backend->ask(rows, 1, answers);
        std::vector<CellKey> next;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            tree.expand(rows[i].cell, answers[i], 1);
            for (unsigned k = 0; k < 8; ++k)
                if (answers[i].grey >> k & 1) next.push_back(child_cell(rows[i].cell, k));
        }
        cells_.push_back(std::move(next));
    }
}

std::vector<OctantMesh> octant_meshes(const std::filesystem::path& data)
{
    std::vector<OctantMesh> meshes;
    const auto add = [&](std::string name, const char* file, int triangles) {
        const std::filesystem::path path = data / "meshes" / file;
        if (!data.empty() && std::filesystem::exists(path))
            meshes.push_back({std::move(name), load_mesh(path)});
        else
            meshes.push_back({"knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, triangles)});
    };
    meshes.push_back({"knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 600)});
    add("bunny", "paper/bunny.obj", 1500);
    add("cow", "paper/cow_5144.obj", 5144);
    add("bunny 69k", "bunny_69k.obj", 69451);
    return meshes;
}

} // namespace oncollide::tools
