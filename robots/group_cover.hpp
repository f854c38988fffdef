#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/aabb.hpp>
#include <oncollide/robots/ball_kernel.hpp>
#include <oncollide/robots/cover.hpp>

namespace oncollide {

const BallKernel& ball_kernel();

/// A float that is larger than the number, if that is positive.
inline float above(double value)
{
    return static_cast<float>(value * (1 + 0x1p-22));
}

/// Float columns of balls.
struct BallList {
    std::vector<float> x, y, z, radius;

    void push_back(const CoverSphere& ball); ///< rounded outward, by at most 2^-22 of the coordinates
    void pad(std::size_t multiple);          ///< with balls that are far from everything
    std::size_t size() const { return x.size(); }
    BallColumns columns() const { return {x.data(), y.data(), z.data(), radius.data()}; }
};

/// The bounding spheres of all parts of a group, in the frame of its link, in blocks of neighbours.
class GroupCover {
public:
    /// @param parts  the part of each sphere
    GroupCover(std::span<const CoverSphere> spheres, std::span<const std::uint32_t> parts, const CoverSphere& whole,
               std::uint32_t link);

    BallBlocks blocks() const;
    std::size_t balls() const { return balls_.size(); }
    const BallList& list() const { return balls_; }
    std::uint32_t part(std::uint32_t ball) const { return parts_[ball]; }
    bool has_one_part() const { return one_part_; }
    const CoverSphere& whole() const { return whole_; }
    const Aabb& box() const { return box_; } ///< bounding box of the spheres
    std::uint32_t link() const { return link_; }
    /// Upper bound on the distance of points of the spheres from the link's origin.
    double size() const { return whole_.centre.norm() + whole_.radius; }

private:
    BallList balls_, around_;
    std::vector<std::uint32_t> parts_; ///< by ball
    bool one_part_;
    CoverSphere whole_;
    Aabb box_;
    std::uint32_t link_;
};

/// A box at a pose.
struct PlacedBox {
    Eigen::Isometry3d pose;
    Eigen::Vector3d centre, half; ///< in the frame of the pose

    PlacedBox(const Aabb& box, const Eigen::Isometry3d& at) : pose(at), centre(box.centre()), half(box.half_extent()) {}
};

/// Finds the parts of groups that bounding spheres cannot rule out.
class NearParts {
public:
    /// @param stretch    upper bound of the factor by which poses of parts stretch lengths
    /// @param clearance  parts this close are near
    NearParts(double stretch, double clearance);

    /// Appends pairs of parts: a's in the upper half of a number, b's in the lower one.
    void find(const GroupCover& a, const Eigen::Isometry3d& link_a, const GroupCover& b,
              const Eigen::Isometry3d& link_b, std::vector<std::uint64_t>& pairs);
    /// Appends the parts that are near a box. Parts with several spheres may be listed more than once.
    void find(const GroupCover& a, const Eigen::Isometry3d& link_a, const PlacedBox& box,
              std::vector<std::uint32_t>& parts);

    /// The reach of two groups whose middles are given as points, up to `size` from the origin of their coordinates.
    float reach(const GroupCover& a, const GroupCover& b, double size) const;
    /// The same, for points and a box.
    float reach(const GroupCover& a, const PlacedBox& box, double size) const;
    /// Upper bound on the distance of near things from the group's middle.
    double radius(const GroupCover& a) const { return a.whole().radius * factor_ + clearance_; }

private:
    double factor_, clearance_;
    double turn_; ///< relative error of lengths in the frame of a link or a body
    std::vector<std::uint32_t> near_a_, near_b_;
};

/// The motion of points at `from` into the frame of `to`, relative to a point there.
void set_frame(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, const Eigen::Vector3d& point,
               BallFrame& frame);

} // namespace oncollide
