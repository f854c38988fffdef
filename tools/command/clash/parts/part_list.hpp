#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/geometry.hpp>

#include "clash/parts/mended_mesh.hpp"
#include "clash/parts/part_details.hpp"
#include "clash/parts/units.hpp"

namespace oncollide::tools {

/// A part of an assembly, in the unit of the report.
struct Part {
    std::string name{};  ///< unique
    std::string label{}; ///< for people: the name, or for an element of a building its class and name, such as
                         ///< "Beam HEA 200 (2)"
    std::string path;    ///< its file, relative to the folder that was named; in an assembly, ":" and the names of all
                         ///< its nodes follow
    std::string id;      ///< unique; stays if other parts come or go, or the files are moved as a whole
    std::string file;
    std::uint32_t mesh;      ///< in PartList::meshes
    std::uint32_t group = 0; ///< in PartList::groups; parts of one group are not compared; 0: no group
    std::uint8_t sets = 0;   ///< bits 1 and 2: in set A, in set B
    Eigen::Isometry3d pose;
    PartDetails details{};
};

/// Which parts are compared: options of the command.
struct PartRules {
    /// Each "file", "node", or a pattern; the first that matches a part determines its group.
    std::vector<std::string> groups{};
    /// Patterns: parts of set A are compared with parts of set B only. Without set B, parts of set A are compared with
    /// all other parts.
    std::vector<std::string> set_a{}, set_b{};
    std::vector<std::string> inputs{}; ///< files and folders of the command line; paths of parts are relative to them
    std::size_t most_parts = 100'000;  ///< as in AssemblyOptions
    bool skip_unreadable = false;      ///< go on without files that cannot be read
    bool strict = false;               ///< a rule that matches nothing is an error
};

/// All parts that are compared.
struct PartList {
    std::vector<std::shared_ptr<const Geometry>> meshes;
    std::vector<Mending> mending{}; ///< by mesh; empty: mend_parts() was not called
    std::vector<Part> parts;
    std::vector<std::string> groups{""};
    std::vector<std::string> files;      ///< that were read
    std::vector<std::string> unreadable; ///< for each other file, the message of its Error
    std::uint64_t triangles = 0;         ///< triangles of all parts; a shared mesh counts once per part
    Aabb bounds;
    /// The largest deflection of a part.
    double deflection() const;
    bool has_sets = false; ///< only parts of set A are compared with parts of set B
    std::vector<std::string> warnings;
};

/// Reads the parts of files: one part per node of a glTF, COLLADA or 3MF file, one part per other file. Throws the
/// errors of load_mesh and check_format() (unless rules.skip_unreadable: then only if no file can be read), and
/// Error{bad_data} for a single part. Patterns match names, node paths and whole paths of parts. Throws Error{usage} if
/// a pattern of a set matches no part, or the rules leave no pair of parts to compare.
PartList read_parts(const std::vector<std::string>& files, const Units& units, const PartRules& rules, int threads);

/// How exact coordinates in float files of this size are after a few roundings: 2^-19 of the largest. For elements of
/// buildings, which are placed in double, of the largest in their own frames.
double precision_of(const PartList& parts);

/// Closes the parts' meshes as mended() does. Cost: as mended(), for all meshes.
void mend_parts(PartList& parts, double distance, int threads);

} // namespace oncollide::tools
