#pragma once
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/model/shape.hpp>

namespace oncollide::oracle {

using LongVector = Eigen::Matrix<long double, 3, 1>;
using LongMatrix = Eigen::Matrix<long double, 3, 3>;

/// A convex solid in the world, in extended precision and by closed forms. Shares nothing with the library except the
/// description of shapes.
class SolidTruth {
public:
    /// All positions are relative to `origin`, so that solids far from the world's origin keep their digits.
    SolidTruth(const Shape& shape, const Eigen::Isometry3d& pose, const Eigen::Vector3d& origin);
    /// The hull of points, such as a triangle, which need not have an inside. It has no faces or edges.
    SolidTruth(std::span<const Eigen::Vector3d> points, const Eigen::Isometry3d& pose, const Eigen::Vector3d& origin);

    /// A sphere and a capsule are a point and a segment, grown by the radius; other solids are their own core.
    long double radius() const { return radius_; }
    /// The point of the core that is extreme along a direction. Not for half-spaces.
    LongVector core_support(const LongVector& direction) const;
    /// The largest coordinate of the solid along a unit vector. A half-space has it along its outward normal only.
    long double height(const LongVector& unit) const;
    /// Distance of a point from the surface, negative inside. Not for the hull of points without faces.
    long double from_surface(const LongVector& point) const;

    bool is_half_space() const { return std::holds_alternative<HalfSpace>(shape_); }
    LongVector outward() const { return turn_.col(2); } ///< of a half-space
    /// The core is a point, a segment, a box or a hull.
    bool has_flat_core() const { return flat_; }
    const LongVector& centre() const { return centre_; }
    long double size() const { return size_; } ///< its diameter, or a bound of it; half-space: 0
    const Eigen::Vector3d& origin() const { return origin_; }
    /// Unit normals of the core's faces, and the directions of its edges. Round solids have their axes here.
    const std::vector<LongVector>& faces() const { return faces_; }
    const std::vector<LongVector>& edges() const { return edges_; }

private:
    void place(const Eigen::Isometry3d& pose);
    void find_hull_faces();
    LongVector local_support(const LongVector& l) const;
    long double from_hull(const LongVector& point) const;

    Shape shape_;
    Eigen::Vector3d origin_;
    LongMatrix turn_;
    LongVector centre_;
    std::vector<LongVector> points_; ///< of a hull, placed
    std::vector<LongVector> faces_, edges_;
    std::vector<long double> heights_; ///< of a hull's faces
    long double radius_ = 0, size_ = 0;
    bool flat_ = false;
};

} // namespace oncollide::oracle
