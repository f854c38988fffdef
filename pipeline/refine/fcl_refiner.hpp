#pragma once
#include <vector>

#include <oncollide/pipeline/refine/pair_refiner.hpp>

namespace oncollide {

/// Any pairs, by FCL on the two bodies as a whole. FCL errs, so what it says counts only where the exact refiner says
/// the same; else the pair keeps the verdict and the bound that it came with.
class FclRefiner final : public PairRefiner {
public:
    explicit FclRefiner(PairRefiner& exact) : exact_(exact) {}

    void refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                std::span<RefineResult> results) override;

private:
    PairRefiner& exact_;
    std::vector<RefineResult> certain_;
};

} // namespace oncollide
