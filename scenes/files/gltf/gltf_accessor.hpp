#pragma once
#include <cstdint>
#include <optional>

#include <Eigen/Geometry>

#include <oncollide/scenes/files/gltf/gltf_buffers.hpp>

namespace oncollide {

/// Numbers of one type at a constant stride in a buffer.
struct GltfColumn {
    const char* data = nullptr;
    std::size_t step = 0;
    int type = 0; ///< glTF's componentType

    const char* at(std::size_t i) const { return data + i * step; }
};

/// The elements of an accessor, read directly from the buffers; some may be replaced (sparse accessors). Private to
/// scenes.
class GltfAccessor {
public:
    /// of_corners: integers; of_positions: points. Throw Error{bad_data} unless all elements are inside their buffers.
    static GltfAccessor of_corners(const GltfDocument& document, GltfBuffers& buffers, const Node& number);
    static GltfAccessor of_positions(const GltfDocument& document, GltfBuffers& buffers, const Node& number);

    /// Numbers of a mesh's instances: floats. Quaternions may also be signed normalised whole numbers of 8 or 16 bits.
    enum class Vectors { points, quaternions };
    static GltfAccessor of_vectors(const GltfDocument& document, GltfBuffers& buffers, const Node& number,
                                   Vectors kind);

    std::size_t size() const { return size_; }
    /// Elements that the file holds one by one: all of them, or only the replaced ones if there is no array.
    std::size_t written() const { return elements_.data ? size_ : replaced_; }
    std::size_t replaced() const { return replaced_; } ///< elements of the sparse part
    std::uint32_t corner(std::size_t i) const;         ///< i < size()
    Eigen::Vector3d position(std::size_t i) const;
    Eigen::Quaterniond quaternion(std::size_t i) const; ///< normalised. Throws Error{bad_data} if it has no direction

private:
    void read(const GltfDocument& document, GltfBuffers& buffers, const Node& accessor, std::size_t numbers);
    void read_sparse(GltfBuffers& buffers, const Node& sparse, std::size_t numbers);
    const char* element(std::size_t i) const; ///< null: zeros
    void numbers(std::size_t i, std::size_t count, double* out) const;

    std::optional<Node> node_; ///< for messages

    GltfColumn elements_, places_, values_; ///< places_ ascend
    std::size_t size_ = 0, replaced_ = 0;
    bool normalized_ = false;
};

} // namespace oncollide
