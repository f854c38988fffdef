#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <oncollide/base/threads/lock_order.hpp>

namespace oncollide {

/// The reasons for which pairs stayed undecided, and the number of their results. Safe from many threads.
class FaultLog {
public:
    void note(const std::string& fault);
    /// One line per reason.
    /// @param others  more faults, appended unless they were noted
    std::vector<std::string> lines(const std::vector<std::string>& others) const;

private:
    mutable OrderedMutex<LockRank::fault_log> noting_;
    std::map<std::string, std::uint64_t> noted_; ///< results by reason
};

} // namespace oncollide
