#include <oncollide/pipeline/models/fault_log.hpp>

#include <fmt/format.h>

namespace oncollide {

void FaultLog::note(const std::string& fault)
{
    const std::lock_guard lock(noting_);
    ++noted_[fault];
}

std::vector<std::string> FaultLog::lines(const std::vector<std::string>& others) const
{
    const std::lock_guard lock(noting_);
    std::vector<std::string> lines;
    for (const auto& [what, results] : noted_)
        lines.push_back(fmt::format("{} ({} result{} undecided)", what, results, results == 1 ? "" : "s"));
    for (const std::string& what : others)
        if (!noted_.contains(what)) lines.push_back(what);
    return lines;
}

} // namespace oncollide
