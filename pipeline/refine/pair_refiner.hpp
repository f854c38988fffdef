#pragma once
#include <chrono>
#include <cstdint>
#include <shared_mutex>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/verdict.hpp>
#include <oncollide/pipeline/refine/pair_cache.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/pipeline/settings.hpp>

namespace oncollide {

/// Two bodies at their poses, to be narrowed down.
struct PairTask {
    std::uint32_t number; ///< of the pair, in the results and in the cache
    Model *a, *b;
    const Eigen::Isometry3d *pose_a, *pose_b;
    double travel = 0; ///< Bodies::travel() of both
};

struct RefineResult {
    Verdict verdict;
    ContactKind kind;
    double bound; ///< as PairResult::bound
};

/// What refiners share with whoever calls them.
struct RefineContext {
    const Settings& settings;
    std::uint32_t frame = 0;
    int threads = 1;
    TreeStats trees;           ///< counted up
    std::vector<Round> rounds; ///< appended to
    std::chrono::steady_clock::time_point began;
    std::shared_mutex* guard = nullptr; ///< of the models' trees; null: no other thread uses them

    /// Are pairs that are not refined yet to be left as they are?
    bool stopped() const { return settings.stop && settings.stop(); }

    /// Held while sphere-trees are walked.
    std::shared_lock<std::shared_mutex> walking() const
    {
        return guard ? std::shared_lock(*guard) : std::shared_lock<std::shared_mutex>();
    }
    /// Held while trees are made and while sphere-trees grow.
    std::unique_lock<std::shared_mutex> changing() const
    {
        return guard ? std::unique_lock(*guard) : std::unique_lock<std::shared_mutex>();
    }

    /// Milliseconds since the frame began.
    double clock_ms() const
    {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count();
    }
};

/// Narrows pairs down: each comes back separate, within its error, colliding or undecided. Clearance, kinds, exactness
/// and budgets are axes that a refiner reads from the settings; which refiner takes a pair is decided in dispatch.hpp.
class PairRefiner {
public:
    virtual ~PairRefiner() = default;
    /// results[i] for tasks[i], for any number of threads and in any company the same. A refiner that cannot tell
    /// leaves what is there.
    /// @param tasks  by ascending number; what their models need was admitted (Dispatch)
    /// @param cache  of the frame's pairs; null: nothing is remembered
    virtual void refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                        std::span<RefineResult> results) = 0;
};

} // namespace oncollide
