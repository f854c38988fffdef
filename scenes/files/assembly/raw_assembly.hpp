#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

/// A node of a file that shows a mesh. Private to scenes.
struct RawPart {
    std::uint32_t node = 0;
    std::uint32_t mesh = 0; ///< in RawAssembly::meshes
    Eigen::Isometry3d pose;
    std::string name{}, path{}; ///< as of AssemblyPart
    std::uint32_t above = 0;    ///< the node above it, or no_node
};
constexpr std::uint32_t no_node = 0xffffffffu;

/// The meshes may lack triangles or have indices out of range.
struct RawAssembly {
    std::vector<RawMesh> meshes;
    std::vector<RawPart> parts;
};

// As the readers of whole meshes (mesh_source.hpp), but each node that has a mesh is a part of its own. Parts share a
// mesh where they differ in a rigid pose alone; what else a node does to its mesh (scale, mirror, shear) is done to the
// vertices. `scale` is of everything, meshes and places.
RawAssembly read_gltf_parts(const MeshSource& source, double scale, int threads);
RawAssembly read_collada_parts(const MeshSource& source, double scale, int threads);
RawAssembly read_3mf_parts(const MeshSource& source, double scale, int threads);

} // namespace oncollide
