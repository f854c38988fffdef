#pragma once
#include <cmath>

#include <Eigen/Core>

#include <oncollide/narrowphase/ocst.hpp>

namespace oncollide {

/// What a tree says about the surface in one cell: it lies in this ball (geometry frame), no farther than `half` from
/// the centre along the unit `normal`. Without a slab `half` is the radius.
struct TreeSphere {
    Eigen::Vector3d centre;
    double radius;
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
    double half = radius;

    /// Is a point in the ball and in the slab, both grown by `slack`?
    bool holds(const Eigen::Vector3d& point, double slack) const
    {
        const Eigen::Vector3d d = point - centre;
        return d.squaredNorm() <= (radius + slack) * (radius + slack) && std::abs(normal.dot(d)) <= half + slack;
    }
};

/// The sphere around a cell, as in the paper. The cell must be alive.
TreeSphere plain_sphere(const Ocst& tree, CellKey cell);

/// The tight bound of the surface in a cell; the plain sphere where the tree has none: of its root, or below
/// Ocst::tight_levels().
TreeSphere tight_sphere(const Ocst& tree, CellKey cell);

} // namespace oncollide
