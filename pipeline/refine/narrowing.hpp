#pragma once
#include <array>
#include <vector>

#include <oncollide/pipeline/refine/containment_test.hpp>
#include <oncollide/pipeline/refine/dispatch.hpp>
#include <oncollide/pipeline/refine/fcl_refiner.hpp>
#include <oncollide/pipeline/refine/gpu_refiner.hpp>
#include <oncollide/pipeline/refine/obb_refiner.hpp>
#include <oncollide/pipeline/refine/sphere_refiner.hpp>
#include <oncollide/pipeline/settings_rules.hpp>

namespace oncollide {

/// True if the exact level must still decide the pair.
inline bool is_open(Verdict verdict)
{
    return verdict == Verdict::within || verdict == Verdict::undecided;
}

/// One level of refinement: passes each pair to its refiner and then, in solid mode, tests for containment. Used by
/// frames and queries.
class Narrowing {
public:
    /// @param gpu  decides pairs of meshes by OBB trees; null: the CPU does
    Narrowing(const Settings& settings, ModelStore& models, Level level, GpuPairs* gpu = nullptr);

    /// Updates results[i] for tasks[i]. Pairs without a refiner keep their results, except that `within` becomes
    /// `undecided` if a budget has no room for an exact decision.
    void run(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache, std::span<Finding> results)
    {
        sort_out(context, tasks);
        run_sorted(context, tasks, cache, results);
    }
    /// run(), if all trees of the tasks exist; otherwise changes nothing and returns false.
    bool run_if_there(RefineContext& context, std::span<const PairTask> tasks, std::span<Finding> results);
    /// True if run() of the level `refine` changes nothing where all trees exist: the exact level decides all pairs.
    bool leaves_to_exact() const { return level_ == Level::refine && dispatch_.leaves_to_exact(); }
    /// True if the trees of a and b exist.
    bool there(const Model& a, const Model& b) const { return dispatch_.there(level_, models_, a, b); }
    /// True if the last run() decided task i.
    bool decided(std::size_t i) const { return refiners_[i] > Refiner::no_room; }

private:
    void sort_out(const RefineContext& context, std::span<const PairTask> tasks);
    bool sort_if_there(const RefineContext& context, std::span<const PairTask> tasks);
    void run_sorted(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                    std::span<Finding> results);
    void give_out(const RefineContext& context, std::span<const PairTask> tasks, int threads);
    void tell_unreadable(const Settings& settings, const PairTask& task, Finding& result) const;
    void refine(Refiner which, PairRefiner& refiner, RefineContext& context, std::span<const PairTask> tasks,
                PairCache* cache, std::span<Finding> results);

    ModelStore& models_;
    const Level level_;
    const Dispatch dispatch_;
    SphereRefiner spheres_;
    ObbRefiner boxes_, exact_;
    GpuRefiner gpu_boxes_, gpu_exact_;
    FclRefiner fcl_;
    ContainmentTest containment_;
    std::vector<Refiner> refiners_;                               ///< by task
    std::array<std::vector<std::uint32_t>, refiner_count> taken_; ///< tasks by refiner
    std::vector<PairTask> tasks_;                                 ///< tasks of one refiner
    std::vector<Finding> results_;
    std::vector<std::uint8_t> apart_;
};

/// Both levels in sequence, for queries. step() runs them as two stages.
class BothLevels {
public:
    BothLevels(const Settings& settings, ModelStore& models, GpuPairs* gpu = nullptr)
        : settings_(settings), refine_(settings, models, Level::refine, gpu),
          exact_(settings, models, Level::exact, gpu),
          exact_alone_(exact_runs(settings) && (refine_.leaves_to_exact() || settings.skip.contains(StageId::refine)))
    {
    }

    /// As Narrowing::run(), but without a cache, because queries do not repeat. All results must be undecided.
    void run(RefineContext& context, std::span<const PairTask> tasks, std::span<Finding> results);

private:
    const Settings& settings_;
    Narrowing refine_, exact_;
    const bool exact_alone_;          ///< the exact level decides all pairs whose trees exist
    std::vector<std::uint32_t> open_; ///< tasks left for the exact level
    std::vector<PairTask> tasks_;     ///< the tasks in open_
    std::vector<Finding> results_;
};

} // namespace oncollide
