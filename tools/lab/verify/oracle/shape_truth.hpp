#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <oncollide/narrowphase/finding.hpp>

#include "verify/oracle/solid_truth.hpp"

namespace oncollide::oracle {

/// A claim of the manifold of two convex solids.
enum class ShapeClaim : std::uint8_t {
    presence,     ///< a region exists where the two meet or are within the margin, and only there
    one_region,   ///< exactly one, with at least one and at most points_per_region points
    kind,         ///< solids that are certainly apart have a region of kind near
    normal,       ///< unit, from a to b
    normal_error, ///< bounds the angle to a half-space's normal; of solids that are apart, to the way across the gap
    depth_upper,  ///< after this way along the normal a plane separates the two
    tight_upper,  ///< ... and not after a much shorter one
    depth_lower,  ///< until this way along the normal they meet, and no shorter way parts them in any direction
    least,        ///< no other direction separates them much sooner
    surface,      ///< points lie on the true surfaces, within depth_error
    offset,       ///< point_a - point_b = depth * normal
    depth,        ///< depth - depth_error is at most depth_upper
    repeated,     ///< no point is there twice
    swapped,      ///< with a and b swapped the same, with the normals reversed
};
constexpr std::string_view shape_claims[] = {"presence",    "one region",  "kind",        "normal", "normal error",
                                             "depth_upper", "tight upper", "depth_lower", "least",  "surface",
                                             "offset",      "depth",       "repeated",    "swapped"};
constexpr std::size_t shape_claim_count = std::size(shape_claims);

/// A claim that is false.
struct ShapeFault {
    ShapeClaim claim;
    std::string what;
};

/// All that the library says of a pair.
struct ShapeAnswer {
    Verdict verdict;
    const Manifold& manifold;
    const Manifold& swapped; ///< of b and a
    ManifoldOptions options;
};

struct ShapeVerdict {
    std::vector<ShapeFault> faults; ///< at most one of each claim
    bool meet = false;              ///< certainly, or beyond doubt not apart
    bool near = false;              ///< certainly apart, and within the margin
};

/// Judges all claims of a manifold of two convex solids, of which at most one is a half-space. A claim is false if it
/// is beyond a doubt of 1e-12 of the solids' sizes and their distance, of 2^-50 of the world's coordinates for points,
/// and of the reference's own error where that is not a closed form. The solids must have one origin.
ShapeVerdict judge_shapes(const SolidTruth& a, const SolidTruth& b, const ShapeAnswer& answer);

/// Judges presence, the kind, the depths, the points and the swapped manifold, for a solid on ground: the union of
/// `parts`.
/// @param may_be_below  the parts are a surface behind which a region may be at any distance
ShapeVerdict judge_on_ground(std::span<const SolidTruth> parts, bool may_be_below, const SolidTruth& solid,
                             bool solid_is_a, const ShapeAnswer& answer);

} // namespace oncollide::oracle
