#pragma once
#include <cstdint>
#include <limits>
#include <vector>

#include <oncollide/base/parallel.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

/// Distances from points to a mesh, in double, by a tree of upright boxes: what trees of spheres and of oriented boxes
/// are judged by, so it shares nothing with them. Cost of a query: about a microsecond.
class SurfaceIndex {
public:
    explicit SurfaceIndex(const Mesh& mesh);

    struct Nearest {
        double distance = std::numeric_limits<double>::infinity();
        Eigen::Vector3d point; ///< of the mesh
    };
    /// The point of the mesh that is nearest; any that is nearer than `enough` will do.
    Nearest nearest(const Eigen::Vector3d& from, double enough = 0) const;
    /// The triangles whose boxes come as near as `radius`: all that do so themselves, and some more.
    void near(const Eigen::Vector3d& from, double radius, FunctionRef<void(std::uint32_t triangle)> visit) const;
    /// Is a point inside, if the mesh is closed? By the parity of a ray that is parallel to nothing in particular.
    bool inside(const Eigen::Vector3d& point) const;

private:
    struct Node {
        Aabb box;
        std::uint32_t begin, end; ///< of its triangles in order_
        std::uint32_t right;      ///< child; the left one follows its parent. 0: a leaf
    };
    void split(std::uint32_t node);

    const Mesh& mesh_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

/// The point of a triangle, whatever its shape, that is nearest.
Eigen::Vector3d nearest_point(const Eigen::Vector3d& from, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                              const Eigen::Vector3d& c);

} // namespace oncollide::tools
