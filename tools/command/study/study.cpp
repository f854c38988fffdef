#include "study/study.hpp"

#include <algorithm>

#include "common/statistics.hpp"

namespace oncollide::tools {

double Study::mean_ms(const std::vector<double>& ms) const
{
    return mean({ms.begin() + warm_up, ms.end()});
}

double Study::median_ms(const std::vector<double>& ms) const
{
    return median({ms.begin() + warm_up, ms.end()});
}

std::optional<double> Study::ratio(const std::vector<double>& ms) const
{
    const auto fcl = std::ranges::find(peers, "FCL", &StudyPeer::name);
    if (fcl == peers.end()) return std::nullopt;
    return mean_ms(fcl->ms) / mean_ms(ms);
}

bool Study::faulty() const
{
    return contradicted || std::ranges::any_of(rows, &StudyRow::faulty);
}

namespace {

bool counts(const StudyRow& row)
{
    return row.variant.certified() && !row.faulty();
}

/// True if no counted result is at least as exact and as fast, and better in one of both.
bool unbeaten(const Study& study, double ms, double error)
{
    const auto beats = [&](double other_ms, double other_error) {
        return other_ms <= ms && other_error <= error && (other_ms < ms || other_error < error);
    };
    return std::ranges::none_of(
               study.rows,
               [&](const StudyRow& row) { return counts(row) && beats(study.mean_ms(row.ms), row.error); }) &&
           std::ranges::none_of(
               study.peers, [&](const StudyPeer& peer) { return peer.right() && beats(study.mean_ms(peer.ms), 0); });
}

} // namespace

bool on_front(const Study& study, const StudyRow& row)
{
    return counts(row) && unbeaten(study, study.mean_ms(row.ms), row.error);
}

bool on_front(const Study& study, const StudyPeer& peer)
{
    return peer.right() && unbeaten(study, study.mean_ms(peer.ms), 0);
}

} // namespace oncollide::tools
