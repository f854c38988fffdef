#pragma once
#include <optional>
#include <string>
#include <vector>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/scenes/motion.hpp>

#include "study/pictures.hpp"
#include "study/workload.hpp"

// Sweeps of a scene's bodies from frame to frame, compared with checks of sampled poses and with FCL's modes.
namespace oncollide::tools {

struct ContinuousOptions {
    std::vector<double> tolerances{1e-2, 1e-3, 1e-4, 1e-6}; ///< of the time, and of the gap in median sizes; descending
    std::vector<int> samples{1, 10, 100, 1000};             ///< poses in a step
    std::size_t count = 1000;                               ///< steps of pairs
    std::size_t of_fcl = 50;                                ///< of these, steps of two meshes that FCL takes, too
};

/// Two bodies that move from one frame to the next.
struct StepOfPair {
    BodyPair pair;
    int frame; ///< in which the step ends
    RigidMotion motion_a, motion_b;
    SweepResult truth{};
    bool meets() const { return truth.verdict == Verdict::colliding; }
    bool is_open() const { return truth.verdict == Verdict::within || truth.verdict == Verdict::undecided; }
};

/// A way to find contacts, over all steps that it takes.
struct ContinuousRow {
    std::string name, setting; ///< e.g. "oncollide", "tolerance 0.0001"
    double share;              ///< the tolerance of the time, or the time between two samples
    std::uint64_t contacts = 0, missed = 0, invented = 0;
    double latest = 0;        ///< largest time from a contact to the one found
    std::vector<double> us{}; ///< by step

    /// @param time  of the contact found; infinite: none
    void add(double time, const StepOfPair& step);
};

struct ContinuousStudy {
    std::string title;
    std::size_t bodies = 0, steps = 0; ///< steps of all pairs that come near; of them, those studied are in `pairs`
    int frames = 0;
    double size = 1; ///< median, m
    std::vector<StepOfPair> pairs;
    std::vector<ContinuousRow> rows;
    std::uint64_t contacts = 0, open = 0;
    std::uint64_t contradicted = 0; ///< steps in which an exact pose collides before `clear_until`
    struct Miss {
        std::size_t step; ///< in pairs
        int samples;      ///< the most that miss it
    };
    std::optional<Miss> worst;
};

/// Plays the scene. Steps of pairs that are in contact at the start of the step belong to the step before, and are left
/// out. The truth is the sweep with the smallest tolerance: a pose of contact, or the certificate that there is none.
ContinuousStudy play_continuous(StudyWorkload& workload, const ContinuousOptions& options);

/// The bodies of the worst miss at the time of contact, from afar and near.
std::optional<PagePicture> draw_worst_miss(const Scene& scene, const ContinuousStudy& study);

} // namespace oncollide::tools
