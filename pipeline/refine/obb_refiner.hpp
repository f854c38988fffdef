#pragma once
#include <optional>
#include <vector>

#include <oncollide/narrowphase/pairs/pair_worker.hpp>
#include <oncollide/pipeline/models/model_store.hpp>
#include <oncollide/pipeline/refine/pair_refiner.hpp>

namespace oncollide {

/// Refines pairs of any kinds with their trees: down to the requested error, or exactly, down to triangles, shapes and
/// cells.
class ObbRefiner final : public PairRefiner {
public:
    enum class Goal : std::uint8_t {
        near, ///< within clearance + error, or separate
        exact ///< colliding or not, with kinds if requested; with a clearance, the distance decides the rest
    };
    ObbRefiner(const ModelStore& models, Goal goal) : models_(models), goal_(goal) {}

    void refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                std::span<Finding> results) override;

    // GpuRefiner, which traverses pairs of meshes in another way, calls these functions.
    /// True if the traversal of a pair of meshes decides it: its memory does not, and rounding is below its error.
    bool needs_walk(const RefineContext& context, const PairTask& task, const PairMemory* memory) const;
    /// A traversal decides the pair only if triangles meet, or no triangles are within this distance (m).
    double open_within(const RefineContext& context, const PairTask& task) const;
    /// The result of a traversal that decided the pair; updates the memory.
    /// @param met    triangles that meet
    /// @param bound  if none meet: a lower bound of the distance
    Finding end_walk(const RefineContext& context, const PairTask& task, PairMemory* memory,
                     const std::optional<TrianglePair>& met, double bound) const;

private:
    /// One thread's working memory.
    struct Worker {
        PairWorker pairs;
        std::uint64_t by_gap = 0;           ///< pairs decided by their gap
        std::uint64_t by_hull = 0;          ///< pairs decided by their outer hulls
        std::uint64_t by_inner_spheres = 0; ///< pairs decided by their inner spheres
    };
    Finding refine(const RefineContext& context, const PairTask& task, PairMemory* memory, Worker& worker) const;
    void remember(const PairTask& task, const Finding& result, PairMemory& memory) const;
    double tolerance_of(const PairTask& task) const
    {
        return goal_ == Goal::near ? models_.max_error(*task.a, *task.b) : 0;
    }
    bool is_sure(const RefineContext& context, const PairTask& task, double tolerance) const;
    Finding refine_there(const RefineContext& context, const PairTask& task, const Finding& known, PairMemory* memory,
                         Worker& worker) const;

    const ModelStore& models_;
    const Goal goal_;
    std::vector<Worker> workers_;
};

} // namespace oncollide
