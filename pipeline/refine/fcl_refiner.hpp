#pragma once
#include <oncollide/pipeline/refine/pair_refiner.hpp>

namespace oncollide {

/// Any pairs, by FCL on the two bodies as a whole.
class FclRefiner final : public PairRefiner {
public:
    void refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                std::span<RefineResult> results) override;
};

} // namespace oncollide
