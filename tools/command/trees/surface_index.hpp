#pragma once
#include <cstdint>
#include <limits>
#include <vector>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

/// Distances from points to a mesh, in double, by a tree of AABBs. Sphere-trees and OBB trees are checked against it,
/// so it shares no code with them. Cost per query: about a microsecond.
class SurfaceIndex {
public:
    explicit SurfaceIndex(const Mesh& mesh);

    struct Nearest {
        double distance = std::numeric_limits<double>::infinity();
        Eigen::Vector3d point; ///< on the mesh
    };
    /// The nearest point of the mesh; stops at any point nearer than `enough`.
    Nearest nearest(const Eigen::Vector3d& from, double enough = 0) const;
    /// Visits all triangles within `radius`, and some others: all triangles of leaves whose AABB is within `radius`.
    void near(const Eigen::Vector3d& from, double radius, FunctionRef<void(std::uint32_t triangle)> visit) const;
    /// True if a point is inside a closed mesh: parity of the crossings of a ray in general position.
    bool inside(const Eigen::Vector3d& point) const;

private:
    struct Node {
        Aabb box;
        std::uint32_t begin, end; ///< range of its triangles in order_
        std::uint32_t right;      ///< the right child; the left one follows its parent. 0: a leaf
    };
    void split(std::uint32_t node);

    const Mesh& mesh_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

/// The nearest point of a triangle of any shape, including degenerate ones.
Eigen::Vector3d nearest_point(const Eigen::Vector3d& from, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                              const Eigen::Vector3d& c);

} // namespace oncollide::tools
