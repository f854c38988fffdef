#pragma once
#include <array>
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

/// Looks for a plane with all of A on one closed side and all of B on the other, among the planes of triangles that
/// touch. Its cost follows the number of the meshes' vertices, not the number of pairs.
///
/// One thread's working memory.
class PartingPlanes {
public:
    /// Keeps references.
    void start(const Mesh& a, const Mesh& b, const RelativePose& b_to_a);
    /// Tries the planes of a triangle of A and a triangle of B that touch.
    void add(std::uint32_t of_a, std::uint32_t of_b) { add(of_a, of_b, true, true); }
    /// The same, but tries no triangle twice, and stops after enough tests.
    void add_new(std::uint32_t of_a, std::uint32_t of_b);
    /// True if one of the last planes has the triangle of A on one closed side, and the triangle of B on the other.
    bool part(std::uint32_t of_a, std::uint32_t of_b);
    /// True if a plane was found that has the meshes on its two closed sides.
    bool part_all() const { return part_all_; }

private:
    void add(std::uint32_t of_a, std::uint32_t of_b, bool try_a, bool try_b);
    void try_plane(const TrianglePoints& face, std::uint32_t of_a, std::uint32_t of_b);

    const Mesh *a_ = nullptr, *b_ = nullptr;
    const RelativePose* b_to_a_ = nullptr;
    std::array<PlaneSides, 4> planes_;
    std::size_t added_ = 0;               ///< planes that part the two triangles they were made for
    std::uint64_t looked_ = 0, most_ = 0; ///< tests of vertices of the whole meshes, and their limit
    bool part_all_ = false;
    std::vector<bool> tried_a_, tried_b_; ///< by triangle: add_new() was called
};

} // namespace oncollide
