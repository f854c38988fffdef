#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/narrowphase/ocst.hpp>
#include <oncollide/scenes/mesh.hpp>

namespace oncollide::tools {

/// The grey cells of a whole tree, level by level, as the cpu backend answers: what other backends are asked about.
class OctantLevels {
public:
    /// Levels 0 to depth - 1. Cost: that of the whole tree.
    OctantLevels(const Mesh& mesh, int depth);

    const RootCell& root() const { return root_; }
    Surface surface() const { return make_surface(geometry_, root_); }
    const Mesh& mesh() const { return std::get<Mesh>(geometry_.data); }
    const std::vector<CellKey>& cells(int level) const { return cells_[static_cast<std::size_t>(level)]; }

private:
    Geometry geometry_;
    RootCell root_;
    std::vector<std::vector<CellKey>> cells_;
};

struct OctantMesh {
    std::string name;
    Mesh mesh;
};

/// Meshes of about 600, 1,500, 5,000 and 69,000 triangles: real ones where the folder has them.
std::vector<OctantMesh> octant_meshes(const std::filesystem::path& data);

} // namespace oncollide::tools
