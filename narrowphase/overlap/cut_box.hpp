#pragma once
#include <array>
#include <vector>

#include <Eigen/Core>

#include <oncollide/base/aabb.hpp>

namespace oncollide {

/// A box that half-spaces cut.
class CutBox {
public:
    explicit CutBox(const Aabb& box);

    /// Keeps the points x with normal . x >= from.
    void keep(const Eigen::Vector3d& normal, double from);
    /// To rounding. Cost: 0.1 to 0.3 microseconds, as keep().
    double volume() const;

private:
    using Polygon = std::vector<Eigen::Vector3d>;
    std::vector<Polygon> faces_; ///< counter-clockwise seen from outside
};

} // namespace oncollide
