#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/scenes/model/mesh.hpp>

#include "clash/clashes.hpp"

namespace oncollide::tools {

/// Parameters of an assembly.
struct PlantedOptions {
    std::size_t parts = 500;
    int triangles = 1000;       ///< of each generated part
    std::vector<Mesh> meshes{}; ///< used in place of generated parts; each is scaled to 100 mm
    std::size_t every = 4;      ///< every N-th site has a planted pair: a clash or a near miss
    double clearance = 2;       ///< mm
};

/// An assembly whose clashes are all known by construction. Millimetres; every coordinate is a float, because STL and
/// glTF store floats.
struct PlantedAssembly {
    struct Part {
        std::string name;
        Mesh mesh; ///< in the assembly's frame
    };
    struct Pair {
        std::string a, b;
        ClashKind kind;
        double depth = -1;     ///< of the deepest vertex; below 0: unknown
        double thickness = -1; ///< least extent of the overlap along an axis
        double gap = -1;       ///< near
    };
    std::vector<Part> parts;
    std::vector<Pair> pairs;
    std::uint64_t triangles = 0;
};

PlantedAssembly make_planted_assembly(const PlantedOptions& options);

/// Writes each part to a binary STL file of its name.
void write_stl_files(const PlantedAssembly& assembly, const std::filesystem::path& folder);
/// Writes all parts to one file, one node per part, in metres as glTF requires, by a scale of the root.
void write_glb_file(const PlantedAssembly& assembly, const std::filesystem::path& file);

/// Faults of the clashes that were found: missing, invented or wrongly measured pairs; one line per fault.
std::vector<std::string> faults_of(const PlantedAssembly& planted, const PartList& parts,
                                   const std::vector<Clash>& found);

} // namespace oncollide::tools
