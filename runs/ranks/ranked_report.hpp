#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/runs/ranks/ranked_run.hpp>

namespace oncollide {

/// One line per rank, or for more than 32 ranks the minimum, mean and maximum of each column; then the imbalance.
std::string rank_table(const std::vector<RankStatistics>& ranks);
/// One row per rank: sums over all frames, and the peak memory. Throws Error{cannot_write}.
void write_rank_csv(const std::filesystem::path& path, const std::vector<RankStatistics>& ranks);
/// A trace as from Report::write_trace(), with one track per rank. Throws Error{cannot_write}.
void write_rank_trace(const std::filesystem::path& path, const std::string& title,
                      const std::vector<std::vector<RankPhase>>& ranks);

} // namespace oncollide
