#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <oncollide/pipeline/pipeline.hpp>

#include "bench/bench.hpp"
#include "study/accuracy_check.hpp"

// FCL and oncollide on the same scene, frame by frame in turn.
namespace oncollide::tools {

constexpr std::size_t stage_count = 5;

/// One frame of both.
struct SceneRow {
    double fcl_ms = 1e300, our_ms = 1e300; ///< the least over repeats
    std::array<double, 4> fcl_parts{};     ///< of that repeat: transforms, update, pairs, narrow
    std::array<double, stage_count> our_parts{};
    std::uint64_t fcl_candidates = 0, fcl_contacts = 0, our_contacts = 0;
    double contacts_ms = 0; ///< ours, of our_ms
    Comparison counts;
    TreeStats trees;
    double gpu_ms = 0, wait_ms = 0;
    std::uint64_t hash = 0;
    std::string regions;    ///< of delimitation, as regions_text() has them
    std::uint64_t left = 0; ///< bodies in those that are left
};

/// Both on the same scene.
struct SceneRuns {
    int first = 0;                          ///< frame
    std::vector<SceneRow> rows;             ///< by frame, from the first on
    std::vector<double> fcl_cold, our_cold; ///< building everything and the first frame, ms
    std::uint64_t hash = 0;
    FclWorld::ModelBytes fcl_bytes;
    std::size_t our_bytes = 0; ///< trees at their largest
    std::string backend = "not run";
};

/// Plays the frames of `scene` that options.shard says, with those that options.only leaves, as often as the options
/// say. Throws Error{internal} when two runs differ.
SceneRuns race(const CompareOptions& options, const Settings& settings, Scene& scene);

} // namespace oncollide::tools
