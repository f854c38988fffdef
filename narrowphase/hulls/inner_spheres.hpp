#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <oncollide/narrowphase/hulls/sphere_overlap_kernel.hpp>
#include <oncollide/narrowphase/relative_pose.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// Balls that the surface of a mesh encloses, and points of the surface, which are balls of radius 0: they show of two
/// meshes that reach deep into each other that their surfaces meet, without a look at any triangle, and how far the
/// meshes would have to move to part. Of a surface that is one piece; where it has open edges there are points alone.
///
/// Why it is so. Let a point be enclosed by both surfaces, and each surface, which is connected, have a point outside
/// of a ball around the other. If the surfaces did not meet, each would lie in one region of what the other one
/// leaves of space, the unbounded one. From the point there is a way to A's surface through what A encloses, where B's
/// surface is not; so A's surface is in the region of the point, which is bounded as B encloses it: a contradiction.
/// Let a point of A's surface be enclosed by B, and another one lie outside of a ball around B: then a way between
/// them on the surface crosses B's. Both hold on while nothing moves farther than the balls overlap, and than the
/// surfaces stand out.
class InnerSpheres {
public:
    /// Cost: 1 to 2 microseconds a triangle.
    explicit InnerSpheres(const Mesh& mesh);

    bool empty() const { return count_ == 0; } ///< the surface is in several pieces
    std::size_t enclosed() const { return enclosed_; }
    std::size_t count() const { return count_; }
    const Eigen::Vector3d& centre() const { return centre_; }
    double radius() const { return radius_; } ///< of the ball around the mesh
    /// Ball number `i`, relative to the centre.
    Eigen::Vector3d ball(std::size_t i) const { return {column_[0][i], column_[1][i], column_[2][i]}; }
    double radius(std::size_t i) const { return column_[3][i]; }
    SphereColumns columns() const
    {
        return {column_[0].data(),
                column_[1].data(),
                column_[2].data(),
                column_[3].data(),
                static_cast<std::uint32_t>(column_[0].size()),
                static_cast<float>(radius_)};
    }
    std::size_t bytes() const { return 4 * column_[0].capacity() * sizeof(float); }

private:
    void add(const Eigen::Vector3d& at, double radius);
    void add_enclosed(const Mesh& mesh);
    void add_points(const Mesh& mesh);

    Eigen::Vector3d centre_;
    double radius_;
    std::array<std::vector<float>, 4> column_; ///< x, y, z, radius
    std::size_t count_ = 0, enclosed_ = 0;
};

/// So far must two bodies move, together, before their surfaces can have parted, m; 0: they were not seen to meet.
/// Cost: 0.1 to 0.2 microseconds.
double meeting_depth(const InnerSpheres& a, const InnerSpheres& b, const RelativePose& b_to_a);

} // namespace oncollide
