#pragma once
#include <memory>
#include <vector>

#include "league/judge/league_case.hpp"
#include "truth/convex_truth.hpp"
#include "verify/oracle/solid_gap.hpp"

// The bodies of a case as unions of convex solids in extended precision.
namespace oncollide::tools::truths {

/// The convex parts whose union a body is, relative to `origin`. A solid mesh is convex.
/// @param faces  triangles and solid meshes have faces: these are needed for widths and for distances from the surface
std::vector<oracle::SolidTruth> parts_of(const LeagueBody& body, const Eigen::Vector3d& origin, bool faces = false);

struct Solids {
    Eigen::Vector3d origin; ///< position of b
    std::vector<oracle::SolidTruth> a, b;

    bool simple() const { return a.size() == 1 && b.size() == 1; }
};
std::shared_ptr<const Solids> solids_of(const LeagueCase& asked, bool faces = false);

/// The body for the second oracle.
std::vector<ConvexSet> sets_of(const LeagueBody& body);

} // namespace oncollide::tools::truths
