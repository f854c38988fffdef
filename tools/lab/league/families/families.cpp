#include "league/families/families.hpp"

namespace oncollide::tools {

std::vector<LeagueFamily> league_families()
{
    std::vector<LeagueFamily> all;
    for (auto* part : {triangle_league, mesh_league, shape_league, contact_league, motion_league, turn_league,
                       self_league, box_league, report_mesh_league, report_league, report_motion_league})
        for (LeagueFamily& family : part()) all.push_back(std::move(family));
    return all;
}

} // namespace oncollide::tools
