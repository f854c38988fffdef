#pragma once
#include <chrono>
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/pairs/pair_task.hpp>
#include <oncollide/pipeline/refine/pair_cache.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/pipeline/settings.hpp>

namespace oncollide {

using WorldMutex = OrderedMutex<LockRank::world, SharedMutex>;

/// Data that refiners share with their caller.
struct RefineContext {
    const Settings& settings;
    std::uint32_t frame = 0;
    int threads = 1;
    TreeStats trees;           ///< incremented
    std::vector<Round> rounds; ///< appended to
    std::chrono::steady_clock::time_point began;
    WorldMutex* guard = nullptr; ///< guards the models' trees; null: no other thread uses them

    /// True if the remaining pairs should stay unrefined.
    bool stopped() const { return settings.stop && settings.stop(); }

    /// Hold it while traversing sphere-trees.
    std::shared_lock<WorldMutex> walking() const
    {
        return guard ? std::shared_lock(*guard) : std::shared_lock<WorldMutex>();
    }
    /// Hold it while making trees and while sphere-trees grow.
    std::unique_lock<WorldMutex> changing() const
    {
        return guard ? std::unique_lock(*guard) : std::unique_lock<WorldMutex>();
    }

    /// Milliseconds since the frame began.
    double clock_ms() const
    {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count();
    }
};

/// Refines pairs: each becomes separate, within its error, colliding or undecided. Refiners read clearance, kinds,
/// exactness and budgets from the settings; dispatch.hpp selects the refiner of a pair.
class PairRefiner {
public:
    virtual ~PairRefiner() = default;
    /// Updates results[i] for tasks[i], independent of the thread count and of the other tasks. A refiner that cannot
    /// decide a pair leaves its result unchanged.
    /// @param tasks  sorted by number; the trees that they need were admitted (Dispatch)
    /// @param cache  the cache of the frame's pairs; null: no memory is kept
    virtual void refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                        std::span<Finding> results) = 0;
};

} // namespace oncollide
