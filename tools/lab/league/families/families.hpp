#pragma once
#include <functional>
#include <string>
#include <vector>

#include "league/judge/league_truth.hpp"

namespace oncollide::tools {

/// Cases of one kind. A case is the family and a seed, and is made anew each time.
struct LeagueFamily {
    std::string name, group;
    league_question question;
    std::string what; ///< one sentence for the page
    std::function<LeagueCase(std::uint64_t seed)> make;
    std::function<LeagueTruth(const LeagueCase& asked)> truth;
    /// Another method's opinion of the truth: false if it contradicts. Empty: the truth's method is the only one.
    std::function<bool(const LeagueCase& asked, const LeagueTruth& truth)> confirms{};
};

/// All families, in the order of the page.
std::vector<LeagueFamily> league_families();

// The parts of league_families().
std::vector<LeagueFamily> triangle_league(); ///< two triangles: meeting, exactly; distances, in rational arithmetic
std::vector<LeagueFamily> mesh_league();     ///< two meshes: meeting, exactly
std::vector<LeagueFamily> shape_league();    ///< two shapes, or a shape on ground: meeting, distance, depth, contacts
std::vector<LeagueFamily> contact_league();  ///< bodies that lie on each other
std::vector<LeagueFamily> motion_league();   ///< casts of shapes, and rays against meshes
std::vector<LeagueFamily> turn_league();     ///< casts of shapes that turn
std::vector<LeagueFamily> self_league();     ///< a mesh against itself
std::vector<LeagueFamily> box_league();      ///< overlapping AABBs of many
// Situations from public bug reports of other libraries, rebuilt.
std::vector<LeagueFamily> report_mesh_league();   ///< two triangles or meshes: meeting, exactly
std::vector<LeagueFamily> report_league();        ///< shapes at rest: meeting, distance, depth, pairs
std::vector<LeagueFamily> report_motion_league(); ///< casts and rays

} // namespace oncollide::tools
