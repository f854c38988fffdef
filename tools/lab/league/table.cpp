#include "league/table.hpp"

#include <algorithm>

namespace oncollide::tools {
namespace {

constexpr std::size_t most_worst = 3, most_seeds = 100;

std::size_t rank_of(const WorstCase& worst)
{
    if (worst.fault == "crashed" || worst.fault == "hung") return 0;
    return std::size_t(std::ranges::find(fault_names, worst.fault) - std::begin(fault_names));
}

void keep_worst(std::vector<WorstCase>& worst)
{
    std::ranges::stable_sort(worst, [](const WorstCase& p, const WorstCase& q) {
        return std::pair(rank_of(p), -p.error) < std::pair(rank_of(q), -q.error);
    });
    if (worst.size() > most_worst) worst.resize(most_worst);
}

} // namespace

void LeagueCell::add(const LeagueCell& other)
{
    cases += other.cases, open += other.open, unsupported += other.unsupported, failed += other.failed;
    crashed += other.crashed, hung += other.hung, nanoseconds += other.nanoseconds;
    for (std::size_t k = 0; k < faults.size(); ++k) faults[k] += other.faults[k];
    worst.insert(worst.end(), other.worst.begin(), other.worst.end());
    keep_worst(worst);
    for (const std::uint64_t seed : other.wrong_seeds)
        if (wrong_seeds.size() < most_seeds) wrong_seeds.push_back(seed);
}

nlohmann::json LeagueCell::json() const
{
    nlohmann::json out{{"cases", cases},
                       {"undecided", open},
                       {"unsupported", unsupported},
                       {"failed", failed},
                       {"crashed", crashed},
                       {"hung", hung},
                       {"ns", answered() ? nanoseconds / double(answered()) : 0}};
    for (std::size_t k = 0; k < faults.size(); ++k) out[std::string(fault_names[k])] = faults[k];
    out["wrong_seeds"] = wrong_seeds, out["worst"] = nlohmann::json::array();
    for (const WorstCase& w : worst)
        out["worst"].push_back(
            {{"seed", w.seed}, {"fault", w.fault}, {"expected", w.expected}, {"given", w.given}, {"error", w.error}});
    return out;
}

LeagueCell LeagueCell::from(const nlohmann::json& json)
{
    LeagueCell cell{.cases = json.at("cases"),
                    .open = json.at("undecided"),
                    .unsupported = json.at("unsupported"),
                    .failed = json.at("failed"),
                    .crashed = json.at("crashed"),
                    .hung = json.at("hung")};
    for (std::size_t k = 0; k < cell.faults.size(); ++k) cell.faults[k] = json.at(std::string(fault_names[k]));
    cell.nanoseconds = json.at("ns").get<double>() * double(cell.answered());
    cell.wrong_seeds = json.at("wrong_seeds").get<std::vector<std::uint64_t>>();
    for (const auto& w : json.at("worst"))
        cell.worst.push_back({w.at("seed"), w.at("fault"), w.at("expected"), w.at("given"),
                              w.at("error").is_null() ? 1e300 : w.at("error").get<double>()});
    return cell;
}

LeagueCell judge_replies(const LeagueFamily& family, const league_library& library,
                         const std::vector<LeagueTruth>& truths, const std::vector<LeagueReply>& replies)
{
    LeagueCell cell;
    const auto add_wrong = [&](WorstCase wrong) {
        if (cell.wrong_seeds.size() < most_seeds) cell.wrong_seeds.push_back(wrong.seed);
        cell.worst.push_back(std::move(wrong));
    };
    for (std::size_t k = 0; k < replies.size(); ++k) {
        const LeagueReply& reply = replies[k];
        ++cell.cases;
        switch (reply.state) {
        case LeagueReply::State::unsupported:
            ++cell.unsupported;
            continue;
        case LeagueReply::State::failed:
            ++cell.failed;
            add_wrong({reply.seed, "failed", "an answer", "the library says that it failed", 0});
            break;
        case LeagueReply::State::crashed:
        case LeagueReply::State::hung: {
            const bool hung = reply.state == LeagueReply::State::hung;
            ++(hung ? cell.hung : cell.crashed);
            add_wrong(
                {reply.seed, hung ? "hung" : "crashed", "an answer", hung ? "none in 5 s, or 2 GB" : "a crash", 0});
            break;
        }
        case LeagueReply::State::answered: {
            cell.nanoseconds += reply.nanoseconds;
            cell.open += truths[k].meet == LeagueTruth::Meet::open && family.question != LEAGUE_PAIRS;
            const LeagueVerdict verdict =
                judge(family.question, truths[k], reply.answer, {library.precision, library.conservative != 0},
                      library.bits == 32 ? 0x1p-24 : 0x1p-53);
            ++cell.faults[std::size_t(verdict.fault)];
            if (verdict.fault != LeagueFault::none && verdict.fault != LeagueFault::extra)
                add_wrong({reply.seed, std::string(fault_names[std::size_t(verdict.fault)]), verdict.expected,
                           verdict.given, verdict.error});
            break;
        }
        }
        if (cell.worst.size() > 4 * most_worst) keep_worst(cell.worst);
    }
    keep_worst(cell.worst);
    return cell;
}

} // namespace oncollide::tools
