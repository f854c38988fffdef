#pragma once
#include "league/families/families.hpp"
#include "verify/cases/case_numbers.hpp"

namespace oncollide::tools {

/// A family of casts, with or without rotation.
/// @param make  all of a case but its question
LeagueFamily moving_family(league_question question, const std::string& name, std::string what,
                           std::function<LeagueCase(CaseNumbers& draw, std::uint64_t seed)> make);

} // namespace oncollide::tools
