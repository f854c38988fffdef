#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/runs/pipeline.hpp>

#include "truth/scene_truth.hpp"

// The measurements of a study of time against error. A study plays one workload with many settings, in alternation.
namespace oncollide::tools {

/// A point of the curve.
struct StudyVariant {
    std::string series; ///< common name of the points of a line: "spheres"
    std::string name;   ///< the series and the accuracy: "spheres, depth 6"
    Settings settings;
    bool certified() const { return oncollide::certified(settings); }
};

/// A pair with a wrong result, or with a bound larger than its distance.
struct Sighting {
    int frame = 0; ///< number of the played frame
    BodyPair pair{};
    double distance = 0, bound = 0; ///< metres
};

/// Bins of the distance of a false positive divided by its bound, a tenth each.
constexpr std::size_t false_positive_bins = 10;

/// A variant's results; the judgement is of all frames.
struct StudyRow : FrameJudgement {
    StudyVariant variant;
    std::string backend;
    std::vector<double> ms;                       ///< by frame played; the least of the repeats
    std::vector<std::array<double, 5>> stage_ms;  ///< from the same repeat
    std::vector<StageStats> stages;               ///< over all frames
    std::array<std::uint64_t, 4> verdicts{};      ///< by Verdict, over all frames
    TreeStats trees;                              ///< sums; maximum for nodes and bytes
    double error = 0;                             ///< the largest bound of a `within` or `undecided` pair, m
    std::vector<double> false_positive_distances; ///< m
    std::array<std::uint64_t, false_positive_bins> false_positives_by_share{};
    std::optional<Sighting> worst_false_positive, first_miss;
    std::uint64_t nodes_needed = 0;         ///< nodes that a test ever reached
    std::optional<std::uint64_t> nodes_all; ///< nodes of the fully grown trees; empty: too many to count

    std::uint64_t fcl_alone = 0;       ///< reported separate and apart, but colliding for FCL
    std::vector<std::uint64_t> hashes; ///< by frame played

    bool faulty() const { return (variant.certified() && missed) || wrong || broken; }
};

/// Another library.
struct StudyPeer {
    std::string name;
    std::vector<double> ms; ///< by frame played; the least of the repeats
    std::uint64_t candidates = 0, colliding = 0, missed = 0, invented = 0;
    std::size_t bytes = 0;
    std::vector<std::string> errors; ///< descriptions of the first errors

    bool right() const { return !missed && !invented; }
};

struct Study {
    std::string title;
    double size = 0; ///< median diagonal of the bodies' boxes, m
    std::uint64_t bodies = 0, triangles = 0;
    int frames = 0, warm_up = 0;    ///< warm_up: frames left out of mean times
    std::uint64_t colliding = 0;    ///< pairs, over all frames
    std::uint64_t contradicted = 0; ///< results in a pose file that the truth contradicts
    std::vector<StudyRow> rows;
    std::vector<StudyPeer> peers;
    std::vector<std::string> left_out; ///< requested peers that cannot play, with the reason

    double mean_ms(const std::vector<double>& ms) const;
    double median_ms(const std::vector<double>& ms) const;
    /// Speed relative to FCL; empty without FCL.
    std::optional<double> ratio(const std::vector<double>& ms) const;
    bool faulty() const;
};

/// True if the row is certified and no other row is both at least as exact and as fast. A peer counts as exact if it
/// made no error.
bool on_front(const Study& study, const StudyRow& row);
bool on_front(const Study& study, const StudyPeer& peer);

} // namespace oncollide::tools
