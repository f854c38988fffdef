#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/narrowphase/spheres/ocst.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

/// The true results for backends: the cells of a mesh's whole tree that its surface intersects, and the intersected
/// octants of each.
class OctantLevels {
public:
    struct Cell {
        CellKey key;
        std::uint8_t truth; ///< intersected octants, by separating axes in double, without tolerance
    };

    /// Levels 0 to depth - 1. Cost: about twice the cost of the whole tree on the cpu backend.
    OctantLevels(const Mesh& mesh, int depth);

    const RootCell& root() const { return root_; }
    Surface surface() const { return mesh_surface(mesh_, root_); }
    const Mesh& mesh() const { return mesh_; }
    int depth() const { return static_cast<int>(levels_.size()); }
    const std::vector<Cell>& level(int l) const { return levels_[static_cast<std::size_t>(l)]; }

private:
    void find_truth(Cell& cell, const std::vector<std::vector<std::uint32_t>>& triangles) const;

    Mesh mesh_;
    RootCell root_;
    std::vector<std::vector<Cell>> levels_;
};

struct NamedMesh {
    std::string name;
    Mesh mesh;
};

/// A real mesh from the folder's meshes/, or a generated knot with as many triangles.
NamedMesh mesh_or_knot(const std::filesystem::path& data, const std::string& file, int triangles);

} // namespace oncollide::tools
