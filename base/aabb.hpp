#pragma once
#include <cmath>
#include <limits>

#include <Eigen/Core>

// The library's own setting. Without it, -mavx would change the alignment of vectors and poses.
static_assert(alignof(Eigen::Matrix4d) == 16,
              "compile with -DEIGEN_MAX_STATIC_ALIGN_BYTES=16, as the CMake target oncollide::oncollide says");

namespace oncollide {

/// Axis-aligned box, closed: touching boxes overlap. Metres. Starts empty (min > max).
struct Aabb {
    Eigen::Vector3d min = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Vector3d max = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());

    void add(const Eigen::Vector3d& point) { min = min.cwiseMin(point), max = max.cwiseMax(point); }
    void add(const Aabb& box) { min = min.cwiseMin(box.min), max = max.cwiseMax(box.max); }
    bool empty() const { return (min.array() > max.array()).any(); }
    bool overlaps(const Aabb& b) const
    {
        return (min.array() <= b.max.array()).all() && (b.min.array() <= max.array()).all();
    }
    bool contains(const Aabb& b) const
    {
        return (min.array() <= b.min.array()).all() && (b.max.array() <= max.array()).all();
    }
    Eigen::Vector3d centre() const { return 0.5 * (min + max); }
    Eigen::Vector3d half_extent() const { return 0.5 * (max - min); }
    double diagonal() const { return (max - min).norm(); }
    double volume() const { return empty() ? 0.0 : (max - min).prod(); }
};

/// Two points of one frame and the line between them, metres. The points may be equal.
struct Segment {
    Eigen::Vector3d from, to;
};

/// Upper bound on the distance between any point of `a` and any point of `b`.
inline double farthest_apart(Aabb a, const Aabb& b)
{
    a.add(b);
    const Eigen::Vector3d edges = a.max - a.min;
    const double squared = edges.squaredNorm(); // may underflow or overflow
    return squared > 1e-280 && squared < 1e300 ? std::sqrt(squared) : edges.stableNorm();
}

} // namespace oncollide
