#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/narrowphase/relative_pose.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// On which sides of a plane the vertices of two meshes are, exactly, each worked out when first needed. Triangles that
/// a plane has on its two closed sides may touch, but never cross; so may meshes, and these share no inside.
///
/// One thread's working memory.
class PlaneSides {
public:
    /// @param plane  corners of a triangle with area, in A's frame
    /// Keeps references. Cost: none but that of growing to the meshes' vertices.
    void start(const TrianglePoints& plane, const Mesh& a, const Mesh& b, const RelativePose& b_to_a);

    /// Is the triangle of A on one closed side, and that of B on the other?
    bool part(const Triangle& of_a, const Triangle& of_b);
    /// Are all vertices of A on one closed side, and all of B on the other? Stops at the first that is not.
    /// @param looked  in and out: vertices looked at
    bool part_all(std::uint64_t& looked);

private:
    int side_of_a(std::uint32_t vertex);
    int side_of_b(std::uint32_t vertex);
    int remembered(std::vector<std::uint32_t>& sides, std::uint32_t vertex, const Eigen::Vector3d& p);

    TrianglePoints plane_;
    const Mesh *a_ = nullptr, *b_ = nullptr;
    const RelativePose* b_to_a_ = nullptr;
    std::uint32_t number_ = 0;               ///< of the plane; four times it, and the side + 1, is what is remembered
    std::vector<std::uint32_t> of_a_, of_b_; ///< by vertex
};

} // namespace oncollide
