#pragma once
#include <array>
#include <limits>

#include <oncollide/narrowphase/gl/picture.hpp>

namespace oncollide::tools {

/// A camera that shows the ball of this radius around `middle`.
/// @param from  unit, towards the camera
Camera camera_from(const Eigen::Vector3d& from, const Eigen::Vector3d& middle, double radius);
/// Sixteen directions all around, from slightly and from far above, the best ones first.
const std::array<Eigen::Vector3d, 16>& good_sides();

/// Finds the camera from which a set of pictures of equal size is seen whole and as large as possible: from the front,
/// slightly from the right and above.
class Framing {
public:
    /// @param width, height  the size of the pictures
    Framing(int width, int height);
    void add(const Picture& picture);
    void add(const Eigen::Vector3d& point, double radius); ///< adds a sphere
    /// Bounds of the contents; empty if there are none.
    const Aabb& bounds() const { return bounds_; }
    /// An arbitrary camera if there are no contents.
    Camera camera() const;

private:
    Camera rotated_;                ///< in the direction of view; its position is not known yet
    Eigen::Isometry3d view_;        ///< view frame of rotated_
    std::array<double, 2> tangent_; ///< tangent of half the view angle: horizontal, vertical
    /// The largest extent beyond a plane of the view pyramid whose apex is at the origin:
    /// right, left, top, bottom.
    std::array<double, 4> reach_;
    Aabb bounds_;
};

} // namespace oncollide::tools
