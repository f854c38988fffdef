#include "study/study.hpp"

#include <algorithm>

#include "bench.hpp"

namespace oncollide::tools {

double Study::mean_ms(const std::vector<double>& ms) const
{
    return mean({ms.begin() + warm_up, ms.end()});
}

double Study::median_ms(const std::vector<double>& ms) const
{
    return median({ms.begin() + warm_up, ms.end()});
}

double Study::ratio(const StudyRow& row) const
{
    return fcl ? mean_ms(fcl->ms) / mean_ms(row.ms) : 0;
}

bool Study::faulty() const
{
    return contradicted || std::ranges::any_of(rows, &StudyRow::faulty);
}

bool on_front(const Study& study, const StudyRow& row)
{
    const auto beats = [](double ms, double error, double other_ms, double other_error) {
        return ms <= other_ms && error <= other_error && (ms < other_ms || error < other_error);
    };
    const double ms = study.mean_ms(row.ms);
    if (!row.variant.certified() || row.faulty()) return false;
    const bool fcl_right = study.fcl && !study.fcl->missed && !study.fcl->invented;
    if (fcl_right && beats(study.mean_ms(study.fcl->ms), 0, ms, row.error)) return false;
    return std::ranges::none_of(study.rows, [&](const StudyRow& other) {
        return other.variant.certified() && !other.faulty() &&
               beats(study.mean_ms(other.ms), other.error, ms, row.error);
    });
}

} // namespace oncollide::tools
