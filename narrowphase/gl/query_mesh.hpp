#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/narrowphase/gl/gpu.hpp>
#include <oncollide/narrowphase/gl/resources.hpp>
#include <oncollide/narrowphase/spheres/octant_kernel.hpp>

namespace oncollide::gl {

/// A vertex array object. Its context must be current when it is made and destroyed.
class VertexArray {
public:
    VertexArray() { glCreateVertexArrays(1, &name_); }
    ~VertexArray() { glDeleteVertexArrays(name_ != 0, &name_); }
    VertexArray(VertexArray&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
    VertexArray& operator=(VertexArray&&) = delete;
    GLuint name() const { return name_; }

private:
    GLuint name_ = 0;
};

/// The triangles of one surface on the GPU, as gl-query draws them; attribute 0 is the corners' positions.
class QueryMesh {
public:
    QueryMesh(std::span<const Primitive> triangles, GlQueryOptions::Primitives primitives);

    /// Draws every triangle.
    void draw() const;
    /// Appends the vertex numbers of a triangle's corners.
    void add_corners(std::uint32_t triangle, std::vector<std::uint32_t>& indices) const;
    /// Draws `count` of the vertex numbers in `indices`, from index `first` on.
    void draw(const Buffer& indices, std::size_t first, std::size_t count) const;
    std::size_t bytes() const;

private:
    VertexArray array_;
    Buffer vertices_;
    Buffer indices_;                     ///< indices of triangles or strips, for the whole mesh; none for a soup
    std::vector<std::uint32_t> corners_; ///< vertex numbers, three per triangle; soup: empty, as vertices are already
                                         ///< in this order
    GLenum mode_ = GL_TRIANGLES;
    GLsizei count_ = 0; ///< vertices or indices of the whole mesh
};

/// Some triangles of meshes, in parts, to be uploaded to the GPU.
class TriangleStream {
public:
    void clear() { indices_.clear(), parts_.clear(); }
    /// Adds a part: the triangles of `mesh` that enter the span's octant.
    void add(const QueryMesh& mesh, const TriangleSpan& triangles);
    /// Returns the number of bytes uploaded.
    std::size_t upload();
    /// Draws part number `part`, which must be uploaded, of its mesh.
    void draw(const QueryMesh& mesh, std::size_t part) const;
    std::size_t bytes() const { return buffer_.bytes(); }

private:
    struct Part {
        std::size_t first, count;
    };
    std::vector<std::uint32_t> indices_;
    std::vector<Part> parts_;
    Buffer buffer_{1 << 16, GL_DYNAMIC_STORAGE_BIT}; ///< grows
};

} // namespace oncollide::gl
