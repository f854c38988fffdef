#pragma once
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/parallel.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/scenes/model/mesh.hpp>

// All pairs of triangles that are near enough, for the truth: plain boxes in double around halves of halves, made of
// minima and maxima alone, so that nothing in them rounds.
namespace oncollide::tools {

/// A mesh, and its triangles in an order in which halves of halves lie together. The mesh must outlive it.
struct HalvedMesh {
    explicit HalvedMesh(const Mesh& mesh);

    const Mesh* mesh;
    std::vector<std::uint32_t> order;
};

/// Its triangles somewhere.
class BoxedTriangles {
public:
    using Box = Eigen::AlignedBox3d;
    /// Calls `place` once a vertex. `halved` must outlive it. Cost: 20 nanoseconds a triangle.
    BoxedTriangles(const HalvedMesh& halved, FunctionRef<Eigen::Vector3d(const Eigen::Vector3d&)> place);

    const Mesh& mesh() const { return *halved_->mesh; }
    const std::vector<Eigen::Vector3d>& points() const { return points_; } ///< the vertices there
    TrianglePoints triangle(std::uint32_t i) const;
    const Box& box() const { return boxes_[1]; }
    double largest() const { return std::max(-box().min().minCoeff(), box().max().maxCoeff()); } ///< coordinate

private:
    friend class NearPairs;
    const Box& fill(std::uint32_t node, std::uint32_t begin, std::uint32_t end);

    const HalvedMesh* halved_;
    std::vector<Eigen::Vector3d> points_;
    std::vector<Box> boxes_, triangle_boxes_; ///< by node: the halves of node k are 2 k and 2 k + 1; by place in order
};

/// Calls look(i, j) for every two triangles whose boxes are at most `cutoff` apart, the nearer halves first. `cutoff`
/// may shrink meanwhile; below 0 it ends the search.
void for_near_pairs(const BoxedTriangles& a, const BoxedTriangles& b, const double& cutoff,
                    FunctionRef<void(std::uint32_t i, std::uint32_t j)> look);

} // namespace oncollide::tools
