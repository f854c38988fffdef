#pragma once
#include <span>
#include <string>
#include <vector>

#include <oncollide/robots/spheres/link_surface.hpp>

namespace oncollide {

/// The coverage of a link by a sphere model. All bounds are certified.
struct CoverJudgement {
    double area = 0;                          ///< area of the surface, m^2
    double uncovered = 0, uncovered_most = 0; ///< bounds of the area that is in no sphere
    double gap = 0,
           gap_most = 0; ///< bounds of the largest distance of a point of the surface from the nearest sphere
    Eigen::Vector3d worst = Eigen::Vector3d::Zero(); ///< the point with distance `gap`
    double over_reach = 0; ///< upper bound on the distance of the spheres' points from the geometry
    bool complete = false; ///< every triangle is covered: the collisions of the link are never missed
};

/// How exactly to judge, metres: triangles in the border of a sphere are divided until their edges are shorter; the two
/// bounds of the gap differ by at most this.
struct JudgeOptions {
    double edge = 2e-4, gap = 1e-5;
};

CoverJudgement judge_cover(const LinkSurface& surface, std::span<const CoverSphere> spheres,
                           const JudgeOptions& options = {});

} // namespace oncollide
