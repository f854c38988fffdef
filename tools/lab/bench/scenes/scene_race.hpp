#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <oncollide/runs/pipeline.hpp>

#include "bench/common/benchmark.hpp"
#include "fcl/fcl_world.hpp"

// FCL and oncollide on the same scene, in alternation, frame by frame.
namespace oncollide::tools {

/// Repeats are runs from frame 0, of which the least time of each frame counts; `only` is "fcl" or "oncollide", or
/// empty; the CSV has a row per frame.
struct CompareOptions : SharedOptions {
    SceneOptions scene;
    SettingsOptions settings;
    int warm_up = 3;       ///< frames at the start that are not timed
    int cold_runs = 5;     ///< cold starts, from the scene to the first frame's results
    bool contacts = false; ///< find all contacts of each pair; with exact predicates
    int timeline = 0;      ///< frames between printed lines; 0: none
    std::string summary;   ///< file of a single row
};

constexpr std::size_t stage_count = 5;

/// Comparison of a frame's pairs with FCL's. Sums over frames with +=.
struct Comparison {
    std::uint64_t pairs = 0;     ///< candidates of the broad phase
    std::uint64_t left_over = 0; ///< not separate: within, undecided or colliding
    std::uint64_t undecided = 0;
    std::uint64_t colliding = 0;          ///< by the exact level
    std::uint64_t fcl_colliding = 0;      ///< by FCL
    std::uint64_t false_positives = 0;    ///< left over, but not colliding for FCL
    std::uint64_t missed = 0;             ///< colliding for FCL and in truth, but not left over: must be 0
    std::uint64_t missed_by_rounding = 0; ///< the same, but apart in truth: rounding of FCL
    /// `colliding` although FCL and the truth say no. 0 with exact fcl.
    std::uint64_t wrong_exact = 0;
    std::string first_missed; ///< names of the bodies
    Comparison& operator+=(const Comparison& other);
};

/// One frame with both libraries.
struct SceneRow {
    double fcl_ms = 1e300, our_ms = 1e300; ///< least of the repeats
    std::array<double, 4> fcl_parts{};     ///< in the same repeat: transforms, update, pairs, narrow
    std::array<double, stage_count> our_parts{};
    std::uint64_t fcl_candidates = 0, fcl_contacts = 0, our_contacts = 0;
    double contacts_ms = 0; ///< part of our_ms
    Comparison counts;
    TreeStats trees;
    double gpu_ms = 0, wait_ms = 0;
    std::uint64_t hash = 0;
    std::string regions;    ///< of delimitation, by regions_text()
    std::uint64_t left = 0; ///< bodies in the regions kept
};

/// Both libraries on the same scene.
struct SceneRuns {
    int first = 0;                          ///< first frame
    std::vector<SceneRow> rows;             ///< by frame, from `first` on
    std::vector<double> fcl_cold, our_cold; ///< building all data, and the first frame, ms
    std::uint64_t hash = 0;
    FclWorld::ModelBytes fcl_bytes;
    std::size_t our_bytes = 0; ///< largest size of the trees
    std::string backend = "not run";
};

/// Plays the frames of options.shard with the libraries of options.only, as often as the options require. Throws
/// Error{internal} if two runs differ.
SceneRuns race(const CompareOptions& options, const Settings& settings, Scene& scene);

/// Prints the results and writes the files of the options. Returns the number of collisions that oncollide missed or
/// reported wrongly.
std::uint64_t report(const CompareOptions& options, const Settings& settings, const Scene& scene,
                     const SceneRuns& runs);

} // namespace oncollide::tools
