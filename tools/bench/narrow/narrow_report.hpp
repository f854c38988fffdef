#pragma once
#include <span>
#include <string>
#include <vector>

#include <oncollide/base/output_file.hpp>

#include "bench/narrow/narrow_race.hpp"

namespace oncollide::tools {

/// A benchmark of the narrow phase that has been run.
struct NarrowResult {
    std::string mesh_a, mesh_b; ///< names
    std::size_t triangles_a = 0, triangles_b = 0;
    double diagonal = 0; ///< of a's box
    std::uint64_t seed = 0;
    NarrowWorkload workload;
    NarrowTruth truth;
    std::vector<NarrowQuery> queries;
    std::vector<NarrowRow> rows;
};

/// One contender's results of one query over some of the poses, in microseconds.
struct NarrowSummary {
    double median = 0, mean = 0, mean_colliding = 0, mean_separate = 0;
    std::uint64_t poses = 0, colliding = 0;
    std::uint64_t missed = 0, extra = 0; ///< poses; of all pairs, triangle pairs
    double error = 0;                    ///< of distances, the largest, over the diagonal
    std::uint64_t hash = 0;              ///< of all results
};

constexpr std::size_t every_group = ~std::size_t{0};
NarrowSummary summarise(const NarrowResult& result, const NarrowRow& row, NarrowQuery query,
                        std::size_t group = every_group);

/// True when a result of oncollide breaks its promise: something missed, or, where it is exact, something wrong.
bool broken_promise(const NarrowResult& result);

/// A table of the contenders, and one a query: medians by group, then over all poses.
void print_narrow(const NarrowResult& result);
/// One row a contender, query and group.
void write_narrow_csv(OutputFile& file, const NarrowResult& result);
/// Median against group, one panel a query.
void draw_narrow_plot(OutputFile& file, const NarrowResult& result);

} // namespace oncollide::tools
