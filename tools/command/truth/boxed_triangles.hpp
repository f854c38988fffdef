#pragma once
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/scenes/model/mesh.hpp>

// Finds all pairs of triangles that are near enough, for the truth. Uses AABBs in double around a binary hierarchy;
// they are computed only from minima and maxima, so nothing is rounded.
namespace oncollide::tools {

/// A mesh, and an order of its triangles for a binary hierarchy. The mesh must outlive it.
struct HalvedMesh {
    explicit HalvedMesh(const Mesh& mesh);

    const Mesh* mesh;
    std::vector<std::uint32_t> order;
};

/// The triangles of a mesh, transformed.
class BoxedTriangles {
public:
    using Box = Eigen::AlignedBox3d;
    /// Calls `place` once per vertex. `halved` must outlive it. Cost: 20 nanoseconds per triangle.
    BoxedTriangles(const HalvedMesh& halved, FunctionRef<Eigen::Vector3d(const Eigen::Vector3d&)> place);

    const Mesh& mesh() const { return *halved_->mesh; }
    const std::vector<Eigen::Vector3d>& points() const { return points_; } ///< the transformed vertices
    TrianglePoints triangle(std::uint32_t i) const;
    const Box& box() const { return boxes_[1]; }
    double largest() const { return std::max(-box().min().minCoeff(), box().max().maxCoeff()); } ///< coordinate

private:
    friend class NearPairs;
    const Box& fill(std::uint32_t node, std::uint32_t begin, std::uint32_t end);

    const HalvedMesh* halved_;
    std::vector<Eigen::Vector3d> points_;
    std::vector<Box> boxes_, triangle_boxes_; ///< by node (children of k: 2 k and 2 k + 1); by index in `order`
};

/// Calls look(i, j) for all pairs of triangles whose AABBs are at most `cutoff` apart, nearer halves first. `cutoff`
/// may shrink during the search; a value below 0 ends it.
void for_near_pairs(const BoxedTriangles& a, const BoxedTriangles& b, const double& cutoff,
                    FunctionRef<void(std::uint32_t i, std::uint32_t j)> look);

} // namespace oncollide::tools
