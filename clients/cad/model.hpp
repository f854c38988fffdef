#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace oncollide::cad {

/// A fault of the file or of the command line; `code` is the exit code, as of oncollide.
struct Fault : std::runtime_error {
    Fault(int exit_code, const std::string& what) : std::runtime_error(what), code(exit_code) {}
    int code;
};
constexpr int usage = 64, bad_data = 65, no_input = 66, internal = 70, cannot_write = 73;

/// Triangles in metres, in the frame of their shape. Vertices on a common edge of two faces are one.
struct Mesh {
    std::vector<std::array<float, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::optional<std::array<double, 4>> colour; ///< linear red, green, blue and opacity
    /// Bound on the distance between the triangles and the true surface, in metres, with the rounding of the vertices.
    double deflection = 0;
};

/// A node of an assembly. Each node but the first has a parent before it.
struct Node {
    std::string name;
    std::array<double, 16> matrix; ///< relative to the parent, column by column; metres
    double scale = 1;              ///< of the matrices of all nodes from the root to this one
    std::vector<std::size_t> children, meshes;
};

struct Model {
    std::vector<Mesh> meshes;
    std::vector<std::string> mesh_names;
    std::vector<Node> nodes;
    std::vector<std::size_t> roots;
    std::vector<std::string> warnings;
};

struct Options {
    double deflection = 0; ///< metres; 0: a thousandth of each shape's diagonal, from 0.01 mm to 1 mm
};

/// Reads a STEP, IGES or BREP file, by its extension. Throws Fault.
Model read_model(const std::string& file, const Options& options);

/// Writes a GLB file: a node for each node, and a mesh that all its instances share. Throws Fault.
void write_glb(const Model& model, const std::string& file);

} // namespace oncollide::cad
