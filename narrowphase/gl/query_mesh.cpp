#include <oncollide/narrowphase/gl/query_mesh.hpp>

#include <algorithm>
#include <array>
#include <limits>

#include <meshoptimizer.h>

namespace oncollide::gl {

namespace {

using Corner = std::array<float, 3>;
constexpr std::uint32_t restart = std::numeric_limits<std::uint32_t>::max(); // the index of
                                                                             // GL_PRIMITIVE_RESTART_FIXED_INDEX

std::vector<Corner> corners_of(std::span<const Primitive> triangles)
{
    std::vector<Corner> corners;
    corners.reserve(3 * triangles.size());
    for (const Primitive& t : triangles)
        for (const auto& p : t.point) corners.push_back({p[0], p[1], p[2]});
    return corners;
}

/// Merges corners at the same position into one vertex. Returns the vertex of each corner.
std::vector<std::uint32_t> weld(std::vector<Corner>& corners)
{
    std::vector<std::uint32_t> vertex(corners.size());
    const std::size_t count = meshopt_generateVertexRemap(vertex.data(), nullptr, corners.size(), corners.data(),
                                                          corners.size(), sizeof(Corner));
    std::vector<Corner> vertices(count);
    meshopt_remapVertexBuffer(vertices.data(), corners.data(), corners.size(), sizeof(Corner), vertex.data());
    corners = std::move(vertices);
    return vertex;
}

std::vector<std::uint32_t> strips_of(const std::vector<std::uint32_t>& indices, std::size_t vertices)
{
    std::vector<std::uint32_t> ordered(indices.size());
    meshopt_optimizeVertexCacheStrip(ordered.data(), indices.data(), indices.size(), vertices);
    std::vector<std::uint32_t> strips(meshopt_stripifyBound(indices.size()));
    strips.resize(meshopt_stripify(strips.data(), ordered.data(), ordered.size(), vertices, restart));
    return strips;
}

/// OpenGL has no empty buffers, so these get room for one element.
template <class T>
Buffer upload(const std::vector<T>& data)
{
    if (data.empty()) return {sizeof(T), 0};
    return {data.size() * sizeof(T), 0, data.data()};
}

} // namespace

QueryMesh::QueryMesh(std::span<const Primitive> triangles, GlQueryOptions::Primitives primitives)
{
    std::vector<Corner> vertices = corners_of(triangles);
    count_ = static_cast<GLsizei>(vertices.size());
    if (primitives != GlQueryOptions::Primitives::soup) {
        const bool strips = primitives == GlQueryOptions::Primitives::strips;
        corners_ = weld(vertices);
        if (strips) corners_ = strips_of(corners_, vertices.size());
        indices_ = upload(corners_);
        count_ = static_cast<GLsizei>(corners_.size());
        mode_ = strips ? GL_TRIANGLE_STRIP : GL_TRIANGLES;
    }
    vertices_ = upload(vertices);
    glVertexArrayVertexBuffer(array_.name(), 0, vertices_.name(), 0, sizeof(Corner));
    glVertexArrayAttribFormat(array_.name(), 0, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(array_.name(), 0, 0);
    glEnableVertexArrayAttrib(array_.name(), 0);
}

void QueryMesh::draw() const
{
    glBindVertexArray(array_.name());
    if (indices_.name() == 0) return glDrawArrays(mode_, 0, count_);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
    glDrawElements(mode_, count_, GL_UNSIGNED_INT, nullptr);
}

void QueryMesh::add_corners(std::uint32_t triangle, std::vector<std::uint32_t>& indices) const
{
    for (std::uint32_t i = 3 * triangle; i < 3 * triangle + 3; ++i)
        indices.push_back(corners_.empty() ? i : corners_[i]);
}

void QueryMesh::draw(const Buffer& indices, std::size_t first, std::size_t count) const
{
    glBindVertexArray(array_.name());
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices.name());
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(count), GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(first * sizeof(std::uint32_t)));
}

std::size_t QueryMesh::bytes() const
{
    return vertices_.bytes() + indices_.bytes() + corners_.capacity() * sizeof(corners_[0]);
}

void TriangleStream::add(const QueryMesh& mesh, const TriangleSpan& triangles)
{
    const std::size_t first = indices_.size();
    for (std::uint32_t i = 0; i < triangles.count; ++i)
        if (triangles.masks[i] >> triangles.octant & 1) mesh.add_corners(triangles.ids[i], indices_);
    parts_.push_back({first, indices_.size() - first});
}

std::size_t TriangleStream::upload()
{
    const std::size_t bytes = indices_.size() * sizeof(indices_[0]);
    if (buffer_.bytes() < bytes) buffer_ = Buffer(2 * bytes, GL_DYNAMIC_STORAGE_BIT);
    glNamedBufferSubData(buffer_.name(), 0, static_cast<GLsizeiptr>(bytes), indices_.data());
    return bytes;
}

void TriangleStream::draw(const QueryMesh& mesh, std::size_t part) const
{
    mesh.draw(buffer_, parts_[part].first, parts_[part].count);
}

} // namespace oncollide::gl
