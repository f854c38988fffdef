#pragma once
#include <array>
#include <optional>
#include <vector>

#include <oncollide/narrowphase/walks/triangle_tests.hpp>
#include <oncollide/pipeline/refine/gpu_pairs.hpp>
#include <oncollide/pipeline/refine/obb_refiner.hpp>
#include <oncollide/pipeline/refine/pose_table.hpp>

namespace oncollide {

/// Refines pairs of meshes on a GPU, a batch at a time, and leaves to the refiner on the CPU: pairs of other kinds,
/// pairs that their memory decides, pairs of meshes that are cooked, deform or have no room on the GPU, and pairs that
/// the GPU leaves open. Results are the CPU's, except that the bounds of separate pairs may be lower.
///
/// The CPU grows the boxes that the GPU needed and did not find after the batch; the GPU has them in the next one.
class GpuRefiner final : public PairRefiner {
public:
    /// Keeps references.
    /// @param gpu  null: the CPU decides all pairs
    GpuRefiner(ObbRefiner& cpu, GpuPairs* gpu) : cpu_(cpu), gpu_(gpu) {}

    void refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                std::span<Finding> results) override;

private:
    void sort(const RefineContext& context, std::span<const PairTask> tasks, PairCache* cache);
    void run_batches(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                     std::span<Finding> results);
    void add(const RefineContext& context, const PairTask& task, PairMemory* memory, std::uint32_t number);
    void batch(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache, std::span<Finding> results,
               std::size_t& next);
    void take(const RefineContext& context, const PairTask& task, PairMemory* memory, const MeshWalkResult& found,
              Finding& result) const;
    void decide_unsure(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                       std::span<const MeshWalkResult> found, std::span<Finding> results);
    void grow_wanted();
    void refine_on_cpu(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                       std::span<Finding> results, std::vector<std::uint32_t>& which);

    ObbRefiner& cpu_;
    GpuPairs* const gpu_;
    // Tasks, by index: for the GPU, for the CPU at once, for the CPU after the batch, and by pair of the batch.
    std::vector<std::uint32_t> mine_, rest_, open_, in_batch_;
    std::vector<std::uint8_t> walks_; ///< by task: the GPU decides it
    PoseTable poses_;
    std::vector<MeshWalkPair> pairs_; ///< of the batch
    std::vector<UnsureTriangles> unsure_;
    std::vector<ObbTree*> trees_; ///< of the batch, by number on the GPU; null: not in it
    struct HeldModel {
        const Model* model = nullptr;
        std::optional<std::uint32_t> tree;
    };
    std::array<HeldModel, 64> held_; ///< models of the batch, by number, that were looked up last
    std::vector<PairTask> tasks_;
    std::vector<Finding> results_;
};

} // namespace oncollide
