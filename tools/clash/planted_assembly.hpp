#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/narrowphase/verdict.hpp>
#include <oncollide/scenes/model/mesh.hpp>

#include "clash/clashes.hpp"

namespace oncollide::tools {

/// What an assembly is made of.
struct PlantedOptions {
    std::size_t parts = 500;
    int triangles = 1000;       ///< of each part that is made
    std::vector<Mesh> meshes{}; ///< parts to use in place of made ones; each is fitted to 100 mm
    std::size_t every = 4;      ///< one place of so many has a pair that is planted, a clash or nearly one
    double clearance = 2;       ///< mm
};

/// An assembly of which all clashes are known, because each was planted by construction. Millimetres; every coordinate
/// is a float, as STL and glTF keep them.
struct PlantedAssembly {
    struct Part {
        std::string name;
        Mesh mesh; ///< where it stands in the assembly
    };
    struct Pair {
        std::string a, b;
        ContactKind kind;
        double depth = -1;     ///< of the deepest vertex; below 0: not known
        double thickness = -1; ///< what is in common is no thinner between two planes along the axes
        double gap = -1;       ///< near
    };
    std::vector<Part> parts;
    std::vector<Pair> pairs;
    std::uint64_t triangles = 0;
};

PlantedAssembly make_planted_assembly(const PlantedOptions& options);

/// Each part as a binary STL file of its name.
void write_stl_files(const PlantedAssembly& assembly, const std::filesystem::path& folder);
/// All in one file, a node for each part, in metres as glTF wants, by a scale of the root.
void write_glb_file(const PlantedAssembly& assembly, const std::filesystem::path& file);

/// What is wrong with clashes that were found: pairs that are missing, invented or measured wrongly; one line each.
std::vector<std::string> faults_of(const PlantedAssembly& planted, const PartList& parts,
                                   const std::vector<Clash>& found);

} // namespace oncollide::tools
