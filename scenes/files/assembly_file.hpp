#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// A mesh at a place. Parts of an assembly may have equal names.
struct AssemblyPart {
    std::string name;    ///< of its node, else of its mesh, else "node 17"; of other files the name without extension
    std::string path;    ///< the names of at most seven nodes above it and its own, with '/' between them
    std::uint32_t above; ///< the number of the node above it; no_node_above: it has none
    std::size_t mesh;    ///< in Assembly::meshes
    Eigen::Isometry3d pose;
};
constexpr std::uint32_t no_node_above = 0xffffffffu;

/// What a file holds, part by part. Parts that are copies of each other share a mesh.
struct Assembly {
    std::vector<std::shared_ptr<const Geometry>> meshes;
    std::vector<AssemblyPart> parts;
};

/// Whether files of that name hold assemblies: glTF, GLB, COLLADA (.dae) and 3MF.
bool is_assembly_file(const std::filesystem::path& path);

/// Reads a mesh file as an assembly: each node of a glTF or COLLADA file, and each object that a 3MF file's build
/// places, is a part if it shows triangles, at its place in the scene; any other file is one part. Throws as load_mesh.
/// @param scale  metres per unit of the file; finite, > 0
Assembly load_assembly(const std::filesystem::path& path, double scale = 1, int threads = 1);

/// The same as a scene of one frame: a body for each part, none of them fixed. Parts of one name get a number behind
/// it.
Scene load_assembly_scene(const std::filesystem::path& path);

} // namespace oncollide
