#pragma once
#include <string>
#include <vector>

#include "bench/narrow/narrow_race.hpp"

namespace oncollide::tools {

/// The results of a benchmark of the narrow phase.
struct NarrowResult {
    std::string mesh_a, mesh_b; ///< names
    std::size_t triangles_a = 0, triangles_b = 0;
    double diagonal = 0; ///< of a's AABB
    std::uint64_t seed = 0;
    NarrowWorkload workload;
    NarrowTruth truth;
    std::vector<NarrowQuery> queries;
    std::vector<NarrowRow> rows;
};

/// True if a result of oncollide breaks its promise: something is missed, or an exact result is wrong.
bool broken_promise(const NarrowResult& result);

/// Prints a table of the contenders, and one table per query: medians by group, then over all poses.
void print_narrow(const NarrowResult& result);
/// Writes one row per contender, query and group. @param line  first line of the file, with its line break
void write_narrow_csv(const std::string& file, const std::string& line, const NarrowResult& result);
/// Writes one row per pose, in the order of the file, with the times of boolean queries.
void write_poses_csv(const std::string& file, const NarrowResult& result);
/// Draws median against group, one panel per query.
void draw_narrow_plot(const std::string& file, const NarrowResult& result);

} // namespace oncollide::tools
