#pragma once
#include <array>
#include <limits>

#include <oncollide/narrowphase/gl/picture.hpp>

namespace oncollide::tools {

/// Finds the camera from which a set of pictures, all of one size, is seen whole and as large as can be: from the
/// front, a little from the right and above.
class Framing {
public:
    Framing();
    void add(const Picture& picture);
    /// What was seen; empty when nothing was.
    const Aabb& bounds() const { return bounds_; }
    /// Any camera will do when nothing was seen.
    Camera camera() const;

private:
    void add(const Eigen::Vector3d& point, double radius);

    Camera rotated_;                   ///< towards where we look; its place is not found yet
    Eigen::Isometry3d view_;          ///< of rotated_
    std::array<double, 2> tangent_{}; ///< of half the view angle: horizontal, vertical
    /// The farthest that anything reaches beyond a plane of the view pyramid when its top is at the origin:
    /// right, left, top, bottom.
    std::array<double, 4> reach_;
    Aabb bounds_;
};

} // namespace oncollide::tools
