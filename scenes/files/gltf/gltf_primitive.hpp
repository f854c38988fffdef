#pragma once
#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <oncollide/scenes/files/gltf/gltf_accessor.hpp>

namespace oncollide {

/// A part of a glTF mesh: corners of triangles. Private to scenes.
struct GltfPrimitive {
    enum Mode { triangles = 4, strip = 5, fan = 6 };

    Node node;
    GltfAccessor positions;
    std::optional<GltfAccessor> indices;
    std::vector<std::pair<double, GltfAccessor>> moves; ///< the morph targets that displace vertices, and their weights
    Mode mode;

    /// Nothing for points and lines. Throws Error{bad_data} naming the place.
    /// @param weights  the weights of the morph targets, as morph_weights() returns them
    static std::optional<GltfPrimitive> read(const GltfDocument& document, GltfBuffers& buffers, const Node& node,
                                             std::span<const double> weights);

    std::size_t corners() const { return indices ? indices->size() : positions.size(); }
    std::size_t count() const { return mode == triangles ? corners() / 3 : corners() - 2; }
    std::size_t replaced() const; ///< elements of sparse accessors that no array holds
    /// The vertices of triangle i, with the winding that the format gives it. Throws Error{bad_data}.
    std::array<std::size_t, 3> triangle(std::size_t i) const;
    Eigen::Vector3d position(std::size_t vertex) const;

private:
    void read_moves(const GltfDocument& document, GltfBuffers& buffers, std::span<const double> weights);
};

/// The weights of the morph targets of a node's mesh: the node's own weights, else the mesh's; empty if no target moves
/// a vertex. The format applies these displacements even if no animation runs. Throws Error{bad_data} unless there is a
/// weight for each target.
std::vector<double> morph_weights(const Node& node, const Node& mesh);

} // namespace oncollide
