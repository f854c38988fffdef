#pragma once
#include <optional>
#include <string>
#include <vector>

#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/narrowphase/finding.hpp>

namespace oncollide::oracle {

using Surface = std::vector<TrianglePoints>;

/// The first claim of a manifold that rational arithmetic contradicts; empty: none. Both surfaces must be closed and
/// outward, their vertices in general position: no vertex on a plane of the other, no two edges in one plane. Shares
/// nothing with the library.
///
/// Tests `lost` for all ends of segments that two triangles share. If the manifold is one region of a common volume,
/// tests also its `depth_lower` (a point stays inside until then), its `depth_upper` (a plane then separates the
/// surfaces) and its `normal_error` (by the exact area vector).
struct ManifoldVerdict {
    std::string fault;
    bool general = true; ///< false: not in general position; nothing was tested
    bool whole = false;  ///< the claims of one region were tested, too
    bool exact = false;  ///< long double could not decide all, so rational arithmetic did
    std::size_t contacts = 0;
};
ManifoldVerdict judge_manifold(const Surface& a, const Surface& b, const Manifold& manifold);

} // namespace oncollide::oracle
