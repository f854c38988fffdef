#include <oncollide/narrowphase/gl/culling/culled_mesh.hpp>

#include <algorithm>
#include <array>
#include <numeric>

namespace oncollide::gl {

namespace {

constexpr const char* culling_vertices = R"(#version 430 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 outward;
layout(location = 0) uniform mat3 linear;
layout(location = 1) uniform vec3 translation;
layout(location = 2) uniform float growth;
layout(location = 3) uniform int axis;
void main()
{
    vec3 p = linear * (position + growth * outward) + translation;
    gl_Position = vec4(axis == 0 ? p.yzx : axis == 1 ? p.zxy : p, 1.0);
}
)";
constexpr const char* culling_fragments = "#version 430 core\nvoid main() {}\n";

/// Coordinates are relative to the centre of the mesh's bounds, in units of their largest half-extent.
struct Vertex {
    float position[3], outward[3];
};

Vertex vertex(const Eigen::Vector3d& position, const Eigen::Vector3d& outward)
{
    const Eigen::Vector3f p = position.cast<float>(), o = outward.cast<float>();
    return {{p[0], p[1], p[2]}, {o[0], o[1], o[2]}};
}

/// Axes of a box around a triangle: along its longest edge, in its plane, and its normal.
Eigen::Matrix3d axes_of(const std::array<Eigen::Vector3d, 3>& p)
{
    std::size_t longest = 0;
    const auto edge = [&](std::size_t k) -> Eigen::Vector3d { return p[(k + 1) % 3] - p[k]; };
    for (const std::size_t k : {1, 2})
        if (edge(k).squaredNorm() > edge(longest).squaredNorm()) longest = k;
    const Eigen::Vector3d along = edge(longest).stableNormalized(), side = edge((longest + 1) % 3).stableNormalized();
    Eigen::Vector3d normal = along.cross(side);
    if (normal.norm() < 1e-6) normal = along.unitOrthogonal(); // nearly a segment
    normal.normalize();
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity(); // a point
    if (along.norm() > 0.5) axes << along, normal.cross(along), normal;
    return axes;
}

/// Halves order[from, to) along the longest axis until no part has over `most` triangles.
void add_runs(const std::vector<Aabb>& boxes, std::vector<std::uint32_t>& order, std::uint32_t from, std::uint32_t to,
              std::size_t most, std::vector<CulledMesh::Run>& runs)
{
    Aabb box;
    for (std::uint32_t i = from; i < to; ++i) box.add(boxes[order[i]]);
    if (to - from <= most) return runs.push_back({from, to - from, box});
    Eigen::Index axis;
    (box.max - box.min).maxCoeff(&axis);
    const std::uint32_t middle = from + (to - from) / 2;
    std::nth_element(order.begin() + from, order.begin() + middle, order.begin() + to,
                     [&](std::uint32_t a, std::uint32_t b) {
                         const double x = boxes[a].centre()[axis], y = boxes[b].centre()[axis];
                         return x < y || (x == y && a < b);
                     });
    add_runs(boxes, order, from, middle, most, runs);
    add_runs(boxes, order, middle, to, most, runs);
}

} // namespace

CulledMesh::CulledMesh(const Mesh& mesh, std::size_t most, bool fattened)
{
    std::vector<std::uint32_t> order(mesh.triangles.size());
    std::iota(order.begin(), order.end(), 0u);
    std::vector<Aabb> boxes;
    for (const std::uint32_t t : order) {
        Aabb& box = boxes.emplace_back();
        for (const Eigen::Vector3d& corner : corners_of(mesh, t)) box.add(corner);
    }
    const auto count = static_cast<std::uint32_t>(order.size());
    add_runs(boxes, order, 0, count, most, runs_);
    whole_ = {0, count, mesh.bounds};
    const double largest = mesh.bounds.half_extent().maxCoeff();
    scale_ = largest > 0 ? largest : 1;
    fattened ? upload_boxes(mesh, order) : upload_triangles(mesh, order);
}

void CulledMesh::upload_triangles(const Mesh& mesh, std::span<const std::uint32_t> order)
{
    corners_ = 3;
    std::vector<Vertex> vertices;
    for (const Eigen::Vector3d& v : mesh.vertices)
        vertices.push_back(vertex((v - whole_.box.centre()) / scale_, Eigen::Vector3d::Zero()));
    std::vector<std::uint32_t> indices;
    for (const std::uint32_t t : order)
        indices.insert(indices.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
    set_buffers(vertices, indices);
}

void CulledMesh::upload_boxes(const Mesh& mesh, std::span<const std::uint32_t> order)
{
    // Corner c is on the high side of axis k if bit k of c is set.
    constexpr std::uint32_t faces[] = {0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                       2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 3, 7, 1, 7, 5};
    corners_ = std::size(faces);
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices;
    for (const std::uint32_t t : order) {
        std::array<Eigen::Vector3d, 3> p = corners_of(mesh, t);
        for (Eigen::Vector3d& corner : p) corner = (corner - whole_.box.centre()) / scale_;
        const Eigen::Matrix3d axes = axes_of(p);
        Eigen::Matrix3d along;
        for (int i = 0; i < 3; ++i) along.col(i) = axes.transpose() * p[static_cast<std::size_t>(i)];
        const Eigen::Vector3d low = along.rowwise().minCoeff(), high = along.rowwise().maxCoeff();
        for (const std::uint32_t corner : faces)
            indices.push_back(static_cast<std::uint32_t>(vertices.size()) + corner);
        for (int c = 0; c < 8; ++c) {
            const Eigen::Vector3d side(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1);
            const Eigen::Vector3d at = (side.array() > 0).select(high, low);
            vertices.push_back(vertex(axes * at, axes * side));
        }
    }
    set_buffers(vertices, indices);
}

template <class V>
void CulledMesh::set_buffers(const std::vector<V>& vertices, const std::vector<std::uint32_t>& indices)
{
    vertices_ = Buffer(vertices.size() * sizeof(V), 0, vertices.data());
    indices_ = Buffer(indices.size() * sizeof(indices[0]), 0, indices.data());
    glVertexArrayVertexBuffer(array_.name(), 0, vertices_.name(), 0, sizeof(V));
    glVertexArrayElementBuffer(array_.name(), indices_.name());
    for (const GLuint attribute : {0u, 1u}) {
        glVertexArrayAttribFormat(array_.name(), attribute, 3, GL_FLOAT, GL_FALSE, 3 * attribute * sizeof(float));
        glVertexArrayAttribBinding(array_.name(), attribute, 0);
        glEnableVertexArrayAttrib(array_.name(), attribute);
    }
}

void CulledMesh::draw(std::uint32_t first, std::uint32_t count) const
{
    glBindVertexArray(array_.name());
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(count * corners_), GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(std::size_t(first) * corners_ * sizeof(std::uint32_t)));
}

CullingView::CullingView(int pixels, bool depth)
    : program_("culling", {{GL_VERTEX_SHADER, culling_vertices}, {GL_FRAGMENT_SHADER, culling_fragments}})
{
    glCreateFramebuffers(1, &framebuffer_);
    if (depth) {
        glCreateRenderbuffers(1, &depth_);
        glNamedRenderbufferStorage(depth_, GL_DEPTH_COMPONENT32F, pixels, pixels);
        glNamedFramebufferRenderbuffer(framebuffer_, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
        glNamedFramebufferDrawBuffer(framebuffer_, GL_NONE);
        glEnable(GL_DEPTH_TEST);
    } else {
        glNamedFramebufferParameteri(framebuffer_, GL_FRAMEBUFFER_DEFAULT_WIDTH, pixels);
        glNamedFramebufferParameteri(framebuffer_, GL_FRAMEBUFFER_DEFAULT_HEIGHT, pixels);
    }
    glUseProgram(program_.name());
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    glViewport(0, 0, pixels, pixels);
}

CullingView::~CullingView()
{
    glDeleteFramebuffers(1, &framebuffer_);
    glDeleteRenderbuffers(1, &depth_);
}

void CullingView::look_at(const Eigen::Vector3d& centre, const Eigen::Vector3d& half)
{
    centre_ = centre, half_ = half;
}

void CullingView::look_along(int axis)
{
    glUniform1i(3, axis);
}

void CullingView::clear_depth()
{
    const float farthest = 1;
    glDepthMask(GL_TRUE);
    glClearNamedFramebufferfv(framebuffer_, GL_DEPTH, 0, &farthest);
}

void CullingView::place(const CulledMesh& mesh, const Eigen::Isometry3d& into, double outward)
{
    const Eigen::Vector3d per_half = half_.cwiseInverse();
    const Eigen::Matrix3f linear = (mesh.scale() * per_half.asDiagonal() * into.linear()).cast<float>();
    const Eigen::Vector3f translation =
        (into * mesh.whole().box.centre() - centre_).cwiseProduct(per_half).cast<float>();
    glUniformMatrix3fv(0, 1, GL_FALSE, linear.data());
    glUniform3fv(1, 1, translation.data());
    glUniform1f(2, static_cast<float>(outward / mesh.scale()));
}

} // namespace oncollide::gl
