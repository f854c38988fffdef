#pragma once
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/scenes/scene.hpp>

#include "truth/judge.hpp"

namespace oncollide::tools {

/// The truth about all pairs of a scene in one frame. All pairs of AABBs are compared, without any code under test.
class SceneTruth {
public:
    /// @param request  the largest clearance, the mode and whether touching counts, of all settings to be judged.
    /// Keeps a reference to `scene`.
    SceneTruth(const Scene& scene, const Settings& request);
    ~SceneTruth();

    const Settings& request() const { return request_; }
    /// Computes the truth at the scene's poses.
    void step();
    /// Pairs that may collide and whose AABBs are within the clearance, sorted.
    std::span<const BodyPair> near() const { return near_; }
    /// Pairs that collide, or are within the clearance, sorted.
    const std::vector<BodyPair>& colliding() const { return colliding_; }
    bool collide(BodyPair pair) const;
    /// True if the pair is so near the clearance that rounding decides: both results are accepted.
    bool open(BodyPair pair) const;
    /// Without a distance, unless it was needed or measured. Pairs that are not near are apart.
    const PairTruth& of(BodyPair pair) const;
    /// The truth with its distance, which is computed if it is not known yet.
    const PairTruth& measured(BodyPair pair);
    /// The distance, less the rounding that the pipeline's bounds may have.
    DistanceTruth distance(BodyPair pair);

private:
    const TruthModel& model(std::uint32_t body) const;
    PairTruth truth(BodyPair pair, bool distance) const;

    const Scene& scene_;
    Settings request_;
    std::vector<std::unique_ptr<TruthModel>> models_; ///< by geometry
    std::vector<BodyPair> near_, colliding_, open_;
    std::vector<PairTruth> truths_;     ///< of near_
    std::map<BodyPair, PairTruth> far_; ///< measured pairs that are not near
    PairTruth apart_;                   ///< of other pairs
};

/// Names of both bodies.
std::string names_of(const Scene& scene, BodyPair pair);

/// The results of one frame, compared with the truth.
struct FrameJudgement {
    std::uint64_t missed = 0;          ///< must be 0
    std::uint64_t wrong = 0;           ///< false collisions; must be 0
    std::uint64_t false_positives = 0; ///< left over, but apart
    std::uint64_t bounds = 0, broken = 0;
    double least_margin = 1e300; ///< smallest bound - distance (within) or distance - bound (separate), m
    double largest_bound = 0;    ///< of checked `within` pairs, m
    std::string first_fault{};
    FrameJudgement& operator+=(const FrameJudgement& other);
};

/// A frame is judged by the verdicts of all pairs, and by these checks.
struct FrameChecks {
    /// Number of certified bounds, evenly spread over the list. Which ones differs with `start`.
    std::size_t bounds = 0, start = 0;
    bool false_positives = false; ///< bounds of all false positives, too
    /// Sees the results that are faults or false positives.
    std::function<void(BodyPair pair, const Finding& result, const Judgement& judgement)> look{};
};

FrameJudgement judge(std::span<const PairResult> answer, SceneTruth& truth, const Scene& scene,
                     const Settings& settings, const FrameChecks& checks);

} // namespace oncollide::tools
