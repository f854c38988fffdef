#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/pipeline/pipeline.hpp>

// What a study of speed against error measures. A study plays one workload with many settings, turn about.
namespace oncollide::tools {

/// One point of the curve.
struct StudyVariant {
    std::string series; ///< what it has in common with the other points of its line: "spheres"
    std::string name;   ///< the series and the dial: "spheres, depth 6"
    Settings settings;
    bool certified() const { return settings.backend != BackendKind::gl_query; }
};

/// A pair that a variant got wrong, or too wide.
struct Sighting {
    int frame = 0; ///< as played
    BodyPair pair{};
    double distance = 0, bound = 0; ///< metres
};

/// Of the distance of false positives over their bound: bins of a tenth.
constexpr std::size_t false_positive_bins = 10;

struct StudyRow {
    StudyVariant variant;
    std::string backend;
    std::vector<double> ms;                       ///< by frame played; the least of the repeats
    std::vector<std::array<double, 5>> stage_ms;  ///< of that repeat
    std::vector<StageStats> stages;               ///< over all frames
    std::array<std::uint64_t, 4> verdicts{};      ///< by Verdict, over all frames
    TreeStats trees;                              ///< sums; nodes and bytes at their largest
    std::uint64_t false_positives = 0;            ///< left over, but apart
    std::uint64_t missed = 0;                     ///< they collide, and were called separate
    std::uint64_t invented = 0;                   ///< called colliding, but apart
    std::uint64_t broken = 0;                     ///< false positives farther apart than their bound
    double error = 0;                             ///< the largest bound of a pair within or undecided, m
    std::vector<double> false_positive_distances; ///< m
    std::array<std::uint64_t, false_positive_bins> false_positives_by_share{};
    std::optional<Sighting> worst_false_positive, first_miss;
    std::uint64_t nodes_needed = 0;         ///< that a test ever reached
    std::optional<std::uint64_t> nodes_all; ///< of the same trees grown everywhere; none: too many to count

    bool faulty() const { return (variant.certified() && missed) || invented || broken; }
};

/// Another library.
struct StudyPeer {
    std::string name;
    std::vector<double> ms; ///< by frame played; the least of the repeats
    std::uint64_t candidates = 0, colliding = 0, missed = 0, invented = 0;
    std::size_t bytes = 0;
    std::vector<std::string> errors; ///< the first of them, in words

    bool right() const { return !missed && !invented; }
};

struct Study {
    std::string title;
    double size = 0; ///< median diagonal of the bodies' boxes, m
    std::uint64_t bodies = 0, triangles = 0;
    int frames = 0, warm_up = 0;    ///< frames that count in no mean of times
    std::uint64_t colliding = 0;    ///< pairs, over all frames
    std::uint64_t contradicted = 0; ///< of the answers beside a pose file, by the truth
    std::vector<StudyRow> rows;
    std::vector<StudyPeer> peers;
    std::vector<std::string> left_out; ///< peers that were requested and do not play, and why

    double mean_ms(const std::vector<double>& ms) const;
    double median_ms(const std::vector<double>& ms) const;
    /// How many times as fast as FCL; none when it does not play.
    std::optional<double> ratio(const std::vector<double>& ms) const;
    bool faulty() const;
};

/// Is the row certified, and no other both as exact and as fast? A peer counts as exact if it erred nowhere.
bool on_front(const Study& study, const StudyRow& row);
bool on_front(const Study& study, const StudyPeer& peer);

} // namespace oncollide::tools
