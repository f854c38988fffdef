#pragma once
#include <string>
#include <vector>

#include <oncollide/scenes/files/assembly/part_placer.hpp>

namespace oncollide {

/// The visible meshes of a file and their poses, with instances resolved. Private to scenes.
struct PlacedMeshes {
    struct Node {
        std::uint32_t above; ///< index in nodes, or no_node
        std::uint32_t name;  ///< index in names
    };
    /// A mesh of a node, with its pose in the world.
    struct Show {
        std::uint32_t node, mesh;
        Eigen::Affine3d pose;
    };
    std::vector<RawMesh> meshes; ///< their indices are in range
    std::vector<std::string> names;
    std::vector<Node> nodes;
    std::vector<Show> shows;

    /// Vertices and triangles of a mesh, and 1.
    std::uint64_t pieces(std::uint32_t mesh) const { return pieces_of(meshes[mesh]); }
    static std::uint64_t pieces_of(const RawMesh& mesh) { return 1 + mesh.vertices.size() + mesh.triangles.size(); }
};

// Equal positions become one vertex. Only meshes are counted here: the caller has counted the nodes (ExpandedSizes).
RawMesh whole_mesh(const MeshSource& source, const PlacedMeshes& placed, ExpansionLimit& expansion);
RawAssembly parts_of(const MeshSource& source, const PlacedMeshes& placed, ExpansionLimit& expansion,
                     const PartsReading& reading);

} // namespace oncollide
