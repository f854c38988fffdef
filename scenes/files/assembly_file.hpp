#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// A mesh at a pose. Parts of an assembly may have equal names.
struct AssemblyPart {
    std::string name;    ///< of its node, else of its mesh, else "node 17"; for other files the file name without
                         ///< extension
    std::string path;    ///< the names of at most seven of its ancestors and its own, separated by '/'
    std::uint32_t above; ///< the number of its parent node; no_node_above: it has none
    std::size_t mesh;    ///< in Assembly::meshes
    Eigen::Isometry3d pose;
};
constexpr std::uint32_t no_node_above = 0xffffffffu;

/// The contents of a file, part by part. Parts that are copies of each other share a mesh.
struct Assembly {
    std::vector<std::shared_ptr<const Geometry>> meshes;
    std::vector<AssemblyPart> parts;
};

/// Whether the file name means an assembly: glTF, GLB, COLLADA (.dae) and 3MF.
bool is_assembly_file(const std::filesystem::path& path);

/// Reads a mesh file as an assembly: each node of a glTF or COLLADA file, and each object that a 3MF file's build
/// places, is a part if it has triangles, at its pose in the scene; any other file is one part. Throws as load_mesh.
/// @param scale  metres per unit of the file; finite, > 0
Assembly load_assembly(const std::filesystem::path& path, double scale = 1, int threads = 1);

/// The same as a scene of one frame: a dynamic body for each part. Parts with equal names get a number appended.
Scene load_assembly_scene(const std::filesystem::path& path);

} // namespace oncollide
