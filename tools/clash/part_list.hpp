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
    std::string name; ///< unique
    std::string file;
    std::uint32_t mesh;  ///< in PartList::meshes
    std::uint32_t group; ///< in PartList::groups; parts of one group are not compared; 0: no group
    Eigen::Isometry3d pose;
};

/// All parts that are compared.
struct PartList {
    std::vector<std::shared_ptr<const Geometry>> meshes;
    std::vector<Part> parts;
    std::vector<std::string> groups{""};
    std::vector<std::string> files;
    std::uint64_t triangles = 0; ///< of all parts; a shared mesh counts once per part
    Aabb bounds;
    std::vector<std::string> warnings;
};

/// The files that `inputs` name: files, and all mesh files below folders, sorted within a folder. Throws
/// Error{no_input} for a path that does not exist and for a folder without mesh files.
std::vector<std::string> files_of(const std::vector<std::string>& inputs);

/// Reads the parts of files: one part per node of a glTF, COLLADA or 3MF file, one part per other file. Throws the
/// errors of load_mesh, and Error{bad_data} for a single part.
/// @param groups  each "file", "node", or a pattern of names; the first match determines a part's group
PartList read_parts(const std::vector<std::string>& files, const Units& units, const std::vector<std::string>& groups,
                    int threads);

} // namespace oncollide::tools
