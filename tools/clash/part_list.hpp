#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/geometry.hpp>

#include "clash/units.hpp"

namespace oncollide::tools {

/// A part of an assembly, in the unit of the report.
struct Part {
    std::string name; ///< no other part has it
    std::string file;
    std::uint32_t mesh;  ///< in PartList::meshes
    std::uint32_t group; ///< in PartList::groups; parts of one group are not compared; 0: in none
    Eigen::Isometry3d pose;
};

/// All parts that are compared.
struct PartList {
    std::vector<std::shared_ptr<const Geometry>> meshes;
    std::vector<Part> parts;
    std::vector<std::string> groups{""};
    std::vector<std::string> files;
    std::uint64_t triangles = 0; ///< of all parts, those that share a mesh too
    Aabb bounds;
    std::vector<std::string> warnings;
};

/// The files that `inputs` name: files, and folders with all mesh files below them. Sorted within a folder. Throws
/// Error{no_input} for what does not exist and for a folder without mesh files.
std::vector<std::string> files_of(const std::vector<std::string>& inputs);

/// Reads the parts of files: the nodes of glTF, COLLADA and 3MF files, all else as one part each. Throws as load_mesh, and Error{usage}
/// for a single part.
/// @param groups  each "file", "node", or a pattern of names: the first that fits a part says its group
PartList read_parts(const std::vector<std::string>& files, const Units& units, const std::vector<std::string>& groups,
                    int threads);

} // namespace oncollide::tools
