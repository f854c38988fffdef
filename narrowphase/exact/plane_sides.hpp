#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// The exact sides of a plane on which the vertices of two meshes are, each computed when it is first needed. Triangles
/// on the two closed sides of a plane may touch, but never cross; the same holds for meshes, whose insides then do not
/// overlap.
///
/// One thread's working memory.
class PlaneSides {
public:
    /// @param plane  corners of a triangle with area, in A's frame
    /// Keeps references. Cost: nothing, apart from growing to the number of the meshes' vertices.
    void start(const TrianglePoints& plane, const Mesh& a, const Mesh& b, const RelativePose& b_to_a);

    /// True if the triangle of A is on one closed side, and the triangle of B on the other.
    bool part(const Triangle& of_a, const Triangle& of_b);
    /// True if all vertices of A are on one closed side, and all of B on the other. Stops at the first that is not.
    /// @param looked  in and out: number of vertices tested
    bool part_all(std::uint64_t& looked);

private:
    int side_of_a(std::uint32_t vertex);
    int side_of_b(std::uint32_t vertex);
    int remembered(std::vector<std::uint32_t>& sides, std::uint32_t vertex, const Eigen::Vector3d& p);

    TrianglePoints plane_;
    const Mesh *a_ = nullptr, *b_ = nullptr;
    const RelativePose* b_to_a_ = nullptr;
    std::uint32_t number_ = 0;               ///< number of the plane; a vertex stores four times this plus its side + 1
    std::vector<std::uint32_t> of_a_, of_b_; ///< by vertex
};

} // namespace oncollide
