#pragma once
#include <array>
#include <cstdint>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/model.hpp>

namespace oncollide {

/// The part of a convex solid's core that faces a direction: a point, a segment or a flat polygon of points on its
/// surface. Curved rims are polygons of points on them.
struct ContactFace {
    static constexpr std::uint32_t most = 64; ///< corners; of a face with more, some are left out

    std::uint32_t count;    ///< of the corners: 1, 2 or more
    Eigen::Vector3d normal; ///< of a polygon, unit, outward
    double off;             ///< a polygon's corners are at most this far from the plane through the first, metres
    double sharp = 1;       ///< of a polygon, see HullFaces::Face
    FeatureBits face;
    std::array<Eigen::Vector3d, most> corner; ///< counter-clockwise seen from outside
    std::array<std::uint32_t, most> number;   ///< numbers of the corners, for their features
    bool rounded; ///< the corners are points of a curve or of a round surface, without vertices

    bool flat() const { return count > 2; }
    FeatureBits vertex(std::uint32_t i) const;
    FeatureBits edge(std::uint32_t i, std::uint32_t k) const; ///< from corner i to corner k
    /// Moves the face, which is in B's frame, into A's.
    void place(const RelativePose& b_to_a);
};

/// Finds the face along a direction (not 0, in the solid's frame). It holds the core's support point along the
/// direction, within rounding.
void find_face(const Model& model, const Eigen::Vector3d& along, ContactFace& face);

} // namespace oncollide
