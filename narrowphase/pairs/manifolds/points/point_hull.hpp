#pragma once
#include <array>
#include <span>
#include <vector>

#include <oncollide/narrowphase/finding.hpp>

namespace oncollide {

inline Eigen::Vector3d middle_of(const ManifoldPoint& p)
{
    return 0.5 * (p.point_a + p.point_b);
}

/// The hull of the middles between point_a and point_b, to which distances are measured.
class PointHull {
public:
    explicit PointHull(std::span<const ManifoldPoint> points);
    /// An upper bound of the squared distance: the distance to a point, side or triangle of the hull; infinite without
    /// points. The search may stop at any value of at most `enough`.
    double distance2(const Eigen::Vector3d& point, double enough = 0) const;

private:
    struct Side {
        Eigen::Vector3d from, way;
        double inverse; ///< 1 / |way|^2; 0 for a point
    };
    struct Face {
        Eigen::Vector3d normal; ///< unit
        std::array<Eigen::Vector3d, 3> inward;
        std::array<double, 3> least;
        double height;
    };
    std::vector<Eigen::Vector3d> points_;
    std::vector<Side> sides_;
    std::vector<Face> faces_;
};

/// How far the points of `left_out` are from the hull of `kept` at most, metres.
double most_lost(std::span<const ManifoldPoint> kept, std::span<const ManifoldPoint> left_out);

} // namespace oncollide
