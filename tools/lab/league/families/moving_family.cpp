#include "league/families/moving_family.hpp"

#include <fmt/format.h>

#include "league/truths/truths.hpp"

namespace oncollide::tools {

LeagueFamily moving_family(league_question question, const std::string& name, std::string what,
                           std::function<LeagueCase(CaseNumbers& draw, std::uint64_t seed)> make)
{
    return {fmt::format("{}: {}", name_of(question), name),
            "motions",
            question,
            std::move(what),
            [question, make](std::uint64_t seed) {
                CaseNumbers draw(seed);
                LeagueCase asked = make(draw, seed);
                asked.question = question;
                return asked;
            },
            truths::first_contact,
            truths::contact_confirmed};
}

} // namespace oncollide::tools
