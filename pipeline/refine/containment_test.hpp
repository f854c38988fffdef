#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/narrowphase/inside/point_location.hpp>
#include <oncollide/pipeline/models/model_store.hpp>
#include <oncollide/pipeline/refine/pair_refiner.hpp>

namespace oncollide {

/// Solid mode: finds pairs whose surfaces do not meet, but with one body or a part of it inside the other.
class ContainmentTest {
public:
    explicit ContainmentTest(ModelStore& models) : models_(models) {}

    /// Pairs with apart[i] set, whose surfaces do not meet, become colliding if one body encloses a part of the other.
    /// Does nothing in surface mode.
    void find(const RefineContext& context, std::span<const PairTask> tasks, std::span<const std::uint8_t> apart,
              std::span<Finding> results);

private:
    /// Whether one body of a pair (the outer one) encloses a part of the other.
    struct Query {
        std::uint32_t task;
        bool outer_is_a;
        ObbTree* tree; ///< the tree of the outer mesh; null if a budget has no room
        bool holds;
    };
    void gather(const RefineContext& context, std::span<const PairTask> tasks, std::span<const std::uint8_t> apart);

    ModelStore& models_;
    std::vector<std::uint8_t> sides_; ///< by task: bodies whose box contains a part of the other; bit 0: a, bit 1: b
    std::vector<Query> queries_;
    std::vector<PointLocator> locators_; ///< by thread
};

} // namespace oncollide
