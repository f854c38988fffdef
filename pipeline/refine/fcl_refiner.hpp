#pragma once
#include <vector>

#include <oncollide/pipeline/refine/pair_refiner.hpp>

namespace oncollide {

/// Refines any pair with FCL on the two whole bodies. FCL has errors, so its result counts only if the exact refiner
/// agrees; otherwise the pair keeps its previous verdict and bound.
class FclRefiner final : public PairRefiner {
public:
    explicit FclRefiner(PairRefiner& exact) : exact_(exact) {}

    void refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                std::span<Finding> results) override;

private:
    PairRefiner& exact_;
    std::vector<Finding> certain_;
};

} // namespace oncollide
