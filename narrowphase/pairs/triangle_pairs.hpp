#pragma once
#include <vector>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>

namespace oncollide {

// Contacts and distances of two hierarchies of triangles (ObbTree or TerrainTree). Exact in the sense of the exact
// level: b's triangles are transformed into a's frame and rounded to double; for these coordinates, all pairs of
// triangles with a common point are found, touching pairs included.

/// Appends contacts sorted by (triangle_a, triangle_b), each pair once. Cost: for two meshes of 5,000 triangles with
/// grown trees, from 7 microseconds to 90 if 240 pairs meet.
/// @param pairs  working memory
template <class A, class B>
void triangle_contacts(TraversalOf<A, B>& walk, A& a, const Eigen::Isometry3d& pose_a, B& b,
                       const Eigen::Isometry3d& pose_b, std::vector<TrianglePair>& pairs,
                       std::vector<Contact>& contacts);

/// Distance within the tolerance plus rounding: 2^-36 of the bodies' sizes and distance, and 2^-46 of the distance of
/// their files' coordinates from the origin. Cost: for two meshes of 5,000 triangles 20 to 400 microseconds; lowest if
/// they meet, highest if they are far apart.
template <class A, class B>
Distance triangle_distance(TraversalOf<A, B>& walk, A& a, const Eigen::Isometry3d& pose_a, B& b,
                           const Eigen::Isometry3d& pose_b, const DistanceOptions& options);

/// The contact of two triangles that meet.
template <class A, class B>
Contact contact_of(const A& a, const Eigen::Isometry3d& pose_a, const B& b, const Eigen::Isometry3d& pose_b,
                   TrianglePair pair);

} // namespace oncollide
