#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include <oncollide/narrowphase/walks/triangle_tests.hpp>
#include <oncollide/pipeline/refine/gpu_pairs.hpp>
#include <oncollide/pipeline/refine/gpu_trees.hpp>
#include <oncollide/pipeline/refine/obb_refiner.hpp>

namespace oncollide {

/// Refines pairs of meshes on a GPU, a batch at a time, and leaves to the refiner on the CPU: pairs of other kinds,
/// pairs that their memory decides, pairs of meshes that are cooked, deform or have no room on the GPU, and pairs that
/// the GPU leaves open. Results are the CPU's, except that the bounds of separate pairs may be lower.
///
/// While the GPU decides a batch, the CPU refines its own pairs, grows the boxes that the GPU missed in the last call,
/// and fills the next batch.
class GpuRefiner final : public PairRefiner {
public:
    /// Keeps references.
    /// @param gpu  null: the CPU decides all pairs
    GpuRefiner(ObbRefiner& cpu, GpuPairs* gpu) : cpu_(cpu), gpu_(gpu) {}

    void refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                std::span<Finding> results) override;

private:
    /// The arguments of refine().
    struct Call {
        RefineContext& context;
        std::span<const PairTask> tasks;
        PairCache* cache;
        std::span<Finding> results;

        PairMemory* memory_of(const PairTask& task) const { return cache ? &(*cache)[task.number] : nullptr; }
    };

    std::size_t find_walks(const Call& call);
    void divide(const Call& call);
    void run_batches(const Call& call);
    void fill(const Call& call, std::span<const std::uint32_t> which, std::span<MeshWalkPair> pairs) const;
    MeshWalkPair pair_of(const Call& call, std::uint32_t number) const;
    void take_batch(const Call& call, std::span<const std::uint32_t> which, Round& round);
    void take(const Call& call, std::uint32_t number, const MeshWalkResult& found) const;
    void decide_unsure(const Call& call, std::span<const std::uint32_t> which, std::span<const MeshWalkResult> found);
    bool decide_unsure(const Call& call, std::uint32_t number, std::span<const UnsureTriangles> listed,
                       const MeshWalkResult& found, TriangleTests& tests) const;
    void refine_on_cpu(const Call& call, std::vector<std::uint32_t>& which);

    ObbRefiner& cpu_;
    GpuPairs* const gpu_;
    // Tasks, by index: for the GPU, for the CPU meanwhile, and for the CPU after the batches.
    std::vector<std::uint32_t> mine_, rest_, open_;
    std::vector<std::uint8_t> walks_;   ///< by task: a walk on the GPU would decide it
    std::vector<GpuTrees::Pair> trees_; ///< by task: the models' numbers
    GpuTrees held_;
    std::vector<UnsureTriangles> unsure_; ///< of a batch, sorted
    std::vector<std::size_t> begins_;     ///< of the pairs in unsure_, and the end
    std::vector<std::uint8_t> settled_;   ///< by pair in unsure_: its triangles decided it
    std::vector<PairTask> tasks_;
    std::vector<Finding> results_;
};

} // namespace oncollide
