#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "league/families/families.hpp"

namespace oncollide::tools {

/// The result of a library to the case of a seed, and how the attempt ended.
struct LeagueReply {
    enum class State : std::int32_t { answered, unsupported, failed, crashed, hung };

    std::uint64_t seed = 0;
    State state = State::failed;
    double nanoseconds = 0; ///< the least of three calls; of pairs: of the first
    league_answer answer{};
    std::vector<std::uint32_t> pairs{};
    std::vector<league_contact> contacts{};
};

/// A library and the file that it comes from.
struct LeagueEntry {
    std::string adapter;
    const league_library* library;
    bool given = false; ///< by --adapter
};

/// The kinds of a case for league_library::supports(): of a ray the body's, of pairs boxes.
std::pair<int, int> kinds_of(const league_case& asked);

/// Queries a library in this process, and writes the replies to standard output, for ask_in_child(). A call that takes
/// longer than 5 s, or more than 2 GB, ends the process.
void answer_in_child(const LeagueFamily& family, const league_library& library, std::uint64_t first,
                     std::uint64_t count);

/// Queries a library about the cases first, first + 1, ... in processes of their own, one after the other: a crash ends
/// one and begins the next. After ten of them the rest counts as crashed or hung, too.
std::vector<LeagueReply> ask_in_child(const LeagueFamily& family, const LeagueEntry& entry, std::uint64_t first,
                                      std::uint64_t count);

} // namespace oncollide::tools
