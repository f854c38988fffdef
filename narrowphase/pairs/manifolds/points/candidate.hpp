#pragma once
#include <cmath>
#include <limits>
#include <numbers>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/manifold_limits.hpp>

namespace oncollide {

constexpr double unbounded = std::numeric_limits<double>::infinity();

/// A point that a region may keep.
struct ManifoldCandidate {
    enum Of : std::uint8_t { of_a, of_b, of_both }; ///< on whose surface the point is; the other's is opposite to it
    Eigen::Vector3d at;
    Of of;
    FeatureBits a, b; ///< 0: not known yet
    double depth = 0; ///< estimated until the point is kept, unless it is of both
    double error = 0;
    bool opposite = true; ///< a point opposite to it was found
    /// The normal of the faces at the point, from a to b; 0: not known. Until the opposite face is found, it is the
    /// normal of the candidate's own face.
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

/// The normal across two faces, given by their normals from a to b, if they are opposite each other; else 0.
inline Eigen::Vector3d normal_across(const Eigen::Vector3d& of_a, const Eigen::Vector3d& of_b)
{
    return of_a.dot(of_b) >= manifold_limits::facing_cosine ? Eigen::Vector3d((of_a + of_b).normalized())
                                                            : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

/// The angle between directions, within rounding; pi if a vector has no length.
inline double angle_between(const Eigen::Vector3d& u, const Eigen::Vector3d& v)
{
    const double angle = std::atan2(u.cross(v).norm(), u.dot(v));
    return u.isZero(0) || v.isZero(0) ? std::numbers::pi : angle;
}

} // namespace oncollide
