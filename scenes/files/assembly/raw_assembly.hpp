#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

/// A node of a file that has a mesh. Private to scenes.
struct RawPart {
    std::uint32_t node = 0;
    std::uint32_t mesh = 0; ///< in RawAssembly::meshes
    Eigen::Isometry3d pose;
    std::string name{}, path{}; ///< as in AssemblyPart
    std::uint32_t above = 0;    ///< the parent node, or no_node
    std::string extras{};       ///< as in AssemblyPart
};
constexpr std::uint32_t no_node = 0xffffffffu;

/// The meshes may lack triangles or have indices out of range.
struct RawAssembly {
    std::vector<RawMesh> meshes;
    std::vector<RawPart> parts;
};

/// Options of load_assembly().
struct PartsReading {
    double scale;
    int threads;
    std::size_t most_parts;
};

// Like the readers of whole meshes (mesh_source.hpp), but each node with a mesh becomes a separate part. Parts share a
// mesh if they differ only in a rigid pose; other transforms of a node (scale, mirror, shear) are applied to the
// vertices. The scale applies to meshes and poses.
RawAssembly read_gltf_parts(const MeshSource& source, const PartsReading& reading);
RawAssembly read_collada_parts(const MeshSource& source, const PartsReading& reading);
RawAssembly read_3mf_parts(const MeshSource& source, const PartsReading& reading);

/// OBJ: each object (`o`) with triangles, or each group (`g`) of a file without objects. Sections of one name are one
/// part; triangles before the first have the file's name.
RawAssembly read_obj_parts(const MeshSource& source, const PartsReading& reading);

} // namespace oncollide
