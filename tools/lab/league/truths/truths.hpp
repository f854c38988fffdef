#pragma once
#include "league/judge/league_truth.hpp"

// The truths of the families, and other methods that confirm them. All take cases of the question in their comments.
namespace oncollide::tools::truths {

// --- Meshes of one triangle.
/// Meeting: linear programming in integers.
LeagueTruth triangles_meet(const LeagueCase& asked);
/// It decides by rational arithmetic instead of integers.
bool meeting_confirmed(const LeagueCase& asked, const LeagueTruth& truth);
/// Distance: rational arithmetic.
LeagueTruth triangles_apart(const LeagueCase& asked);
/// Integers decide whether they meet, and long double how far apart they are.
bool distance_confirmed(const LeagueCase& asked, const LeagueTruth& truth);

// --- Two meshes, both solid or neither.
/// Meeting: linear programming and winding numbers in integers.
LeagueTruth meshes_meet(const LeagueCase& asked);
/// By the distance of all pairs of triangles in long double: it cannot be large where they meet, or 0 where they do
/// not.
bool meshes_confirmed(const LeagueCase& asked, const LeagueTruth& truth);

// --- Shapes; and shapes on meshes, terrains and maps, which are a. A solid mesh is convex.
/// Meeting and distance: GJK and closed forms in long double.
LeagueTruth shapes_apart(const LeagueCase& asked);
/// Another GJK, in other arithmetic, finds on the geometries themselves whether they are apart, and how far.
bool gap_confirmed(const LeagueCase& asked, const LeagueTruth& truth);
/// Depth of two shapes, judged where the least translation is known exactly.
LeagueTruth shapes_deep(const LeagueCase& asked);

/// Contacts: depth, positions, and where the case has a footprint, the normal and the support.
LeagueTruth contacts(const LeagueCase& asked);
/// Another GJK finds the bodies apart or not, and tests the footprint's depth along its normal.
bool contacts_confirmed(const LeagueCase& asked, const LeagueTruth& truth);

/// The first contact of a shape, mesh, terrain or map with the shape b, which moves straight, or turns, too. The gap of
/// a convex part is a convex function of time on straight motions; on others, by conservative advancement.
LeagueTruth first_contact(const LeagueCase& asked);
/// Another GJK finds them apart before the contact, and not far apart at it.
bool contact_confirmed(const LeagueCase& asked, const LeagueTruth& truth);

// --- Rays against a mesh's triangles, or the solid cells of a map.
/// In rational arithmetic.
LeagueTruth first_hit(const LeagueCase& asked);
/// Integers decide, with the ray as a triangle of no area.
bool hit_confirmed(const LeagueCase& asked, const LeagueTruth& truth);

/// Pairs of boxes whose numbers are exact in float.
LeagueTruth overlapping(const LeagueCase& asked);

} // namespace oncollide::tools::truths
