#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/pipeline/ranks/ranked_run.hpp>

namespace oncollide {

/// One line a rank, or, of more than 32, the least, the mean and the most of each column; then the imbalance.
std::string rank_table(const std::vector<RankStatistics>& ranks);
/// One row a rank: sums over the frames, and the most memory. Throws Error{cannot_write}.
void write_rank_csv(const std::filesystem::path& path, const std::vector<RankStatistics>& ranks);
/// A trace as Report::write_trace() gives, with a track for each rank. Throws Error{cannot_write}.
void write_rank_trace(const std::filesystem::path& path, const std::string& title,
                      const std::vector<std::vector<RankPhase>>& ranks);

} // namespace oncollide
