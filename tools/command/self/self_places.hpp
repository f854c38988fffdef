#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/pipeline/world.hpp>

namespace oncollide::tools {

using TrianglesThatMeet = PairOf<std::uint32_t>;

/// Pairs of triangles of one mesh that meet, connected by triangles with a common vertex. Vertices at one position are
/// one vertex.
struct SelfPlace {
    std::vector<TrianglesThatMeet> pairs; ///< sorted
    Aabb box;                             ///< around the common points of its triangles
};

/// The places of all pairs; places with more pairs come first.
std::vector<SelfPlace> places_of(const Mesh& mesh, const std::vector<TrianglesThatMeet>& pairs);

CommonSegment segment_of(const Mesh& mesh, TrianglesThatMeet pair);

/// One line about a place: its number of pairs, where it is, and two of its triangles. Coordinates below the rounding
/// errors of a mesh of this size are printed as 0.
/// @param bounds  of the mesh
/// @param unit    "m"
std::string place_text(const SelfPlace& place, const Aabb& bounds, std::string_view unit);

} // namespace oncollide::tools
