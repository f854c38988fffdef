#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/gl/query_mesh.hpp>
#include <oncollide/narrowphase/gl/resources.hpp>
#include <oncollide/scenes/model/mesh.hpp>

// The context of these objects must be current whenever they are used or destroyed.
namespace oncollide::gl {

/// A mesh on the GPU, its triangles in runs that lie close together.
class CulledMesh {
public:
    struct Run {
        std::uint32_t first, count; ///< triangles, in the order of drawing
        Aabb box;                   ///< geometry frame
    };

    /// @param most     triangles in a run
    /// @param fattened draw a box around each triangle; place() enlarges the boxes
    CulledMesh(const Mesh& mesh, std::size_t most, bool fattened);

    const Run& whole() const { return whole_; }
    std::span<const Run> runs() const { return runs_; }
    double scale() const { return scale_; } ///< metres per unit of the vertices
    void draw(std::uint32_t first, std::uint32_t count) const;

private:
    void upload_triangles(const Mesh& mesh, std::span<const std::uint32_t> order);
    void upload_boxes(const Mesh& mesh, std::span<const std::uint32_t> order);
    template <class V>
    void set_buffers(const std::vector<V>& vertices, const std::vector<std::uint32_t>& indices);

    double scale_;
    Run whole_;
    std::vector<Run> runs_;
    std::uint32_t corners_; ///< indices per triangle
    VertexArray array_;
    Buffer vertices_, indices_;
};

/// An orthographic view of a box-shaped volume. It needs a context of its own: OpenGL's state is set only once.
class CullingView {
public:
    /// @param depth  true for a view with a depth buffer
    CullingView(int pixels, bool depth);
    ~CullingView();
    CullingView(const CullingView&) = delete;
    CullingView& operator=(const CullingView&) = delete;

    /// Views the box with this centre and these half-extents.
    void look_at(const Eigen::Vector3d& centre, const Eigen::Vector3d& half);
    void look_along(int axis);
    void clear_depth();
    /// Places the drawings from now on.
    /// @param into     moves the mesh into the frame of the view's box
    /// @param outward  enlarges the boxes of a fattened mesh on every side
    void place(const CulledMesh& mesh, const Eigen::Isometry3d& into, double outward = 0);

private:
    Program program_;
    GLuint framebuffer_ = 0, depth_ = 0;
    Eigen::Vector3d centre_, half_;
};

} // namespace oncollide::gl
