#pragma once
#include <array>
#include <string_view>
#include <vector>

#include <oncollide/scenes/files/json/json_node.hpp>
#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

/// Returns `node`, which must be an array, for iteration.
Node list_of(const Node& node);

/// The JSON of a glTF or GLB file, and GLB's binary chunk. Private to scenes.
class GltfDocument {
public:
    enum List { scenes, nodes, meshes, accessors, buffer_views, buffers };

    /// Throws Error{bad_data} unless the file is glTF 2 and requires no extension that would change a mesh.
    explicit GltfDocument(const MeshSource& source);
    GltfDocument(const GltfDocument&) = delete;
    GltfDocument& operator=(const GltfDocument&) = delete;

    const MeshSource& source() const { return source_; }
    Node root() const { return Node(tape_); }
    const std::vector<Node>& all(List list) const { return lists_[list]; }
    /// The index in `list` that `number` gives. Throws Error{bad_data} if it is out of range.
    std::size_t index(List list, const Node& number) const;
    const Node& at(List list, const Node& number) const { return lists_[list][index(list, number)]; }
    std::string_view binary_chunk() const { return binary_chunk_; } ///< empty if there is none
    bool is_quantized() const { return is_quantized_; }             ///< positions may be integers

private:
    std::string_view split_glb();
    void check_extensions();

    const MeshSource& source_;
    JsonTape tape_;
    std::array<std::vector<Node>, 6> lists_;
    std::string_view binary_chunk_;
    bool is_quantized_ = false;
};

} // namespace oncollide
