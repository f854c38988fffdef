#pragma once
#include <string>
#include <vector>

#include "league/table.hpp"

namespace oncollide::tools {

/// The results of a league.
struct LeagueTable {
    const std::vector<LeagueFamily>& families;
    const std::vector<LeagueEntry>& libraries;
    std::vector<std::vector<LeagueCell>> cells; ///< by family and library

    LeagueCell sum(std::size_t library) const;
    /// Wrong results, crashes and endless loops of a library; 0 if it takes no part.
    std::uint64_t wrong_of(std::string_view library) const;
};

/// A line for each library, and for each family the number of wrong results of each.
std::string text_of(const LeagueTable& table);
/// Writes league.html, league.json and league.csv.
void write_reports(const std::string& folder, const LeagueTable& table);

} // namespace oncollide::tools
