#pragma once
#include <array>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "league/answering.hpp"

namespace oncollide::tools {

/// A wrong result, for the page.
struct WorstCase {
    std::uint64_t seed;
    std::string fault, expected, given;
    double error;
};

/// The results of a library for the cases of a family.
struct LeagueCell {
    std::uint64_t cases = 0, open = 0;                          ///< open: rounding decides, so every result is right
    std::array<std::uint64_t, std::size(fault_names)> faults{}; ///< by LeagueFault; [0]: right results
    std::uint64_t unsupported = 0, failed = 0, crashed = 0, hung = 0;
    double nanoseconds = 0;                   ///< sum over all results
    std::vector<WorstCase> worst{};           ///< the gravest three
    std::vector<std::uint64_t> wrong_seeds{}; ///< of the first hundred results that are wrong, failed or none

    std::uint64_t answered() const { return cases - unsupported - failed - crashed - hung; }
    std::uint64_t right() const { return faults[0]; }
    std::uint64_t extra() const { return faults[std::size_t(LeagueFault::extra)]; }
    std::uint64_t wrong() const { return answered() - right() - extra(); }
    void add(const LeagueCell& other);
    nlohmann::json json() const;
    static LeagueCell from(const nlohmann::json& json);
};

/// Judges the replies of a library to some cases.
/// @param truths  by reply
LeagueCell judge_replies(const LeagueFamily& family, const league_library& library,
                         const std::vector<LeagueTruth>& truths, const std::vector<LeagueReply>& replies);

} // namespace oncollide::tools
