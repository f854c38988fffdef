#pragma once
#include <mutex>
#include <optional>
#include <vector>

#include <oncollide/base/parallel.hpp>
#include <oncollide/narrowphase/inside/point_location.hpp>
#include <oncollide/pipeline/model_store.hpp>
#include <oncollide/pipeline/refine/pair_refiner.hpp>

namespace oncollide {

/// A mesh of so many triangles takes longer to be told apart into its parts than a first answer should.
constexpr std::size_t many_triangles = 1 << 17;

/// A point, in the world, of a part of one body that lies inside the other, their surfaces being apart.
/// @param around  the surface around a model's inside; null: it has none
std::optional<Eigen::Vector3d> one_holds_the_other(const PairTask& task, PointLocator& locator,
                                                   FunctionRef<ObbTree*(const Model&)> around);

/// Solid mode: finds the pairs of which one body is inside the other, or a part of it, their surfaces being apart.
class ContainmentTest {
public:
    explicit ContainmentTest(ModelStore& models) : models_(models) {}

    /// Pairs with `apart[i]`, whose surfaces are known not to meet, become colliding where one encloses the other.
    /// In surface mode there are none.
    void find(const RefineContext& context, std::span<const PairTask> tasks, std::span<const std::uint8_t> apart,
              std::span<RefineResult> results);

private:
    /// Does one body of a pair, the outer one, hold the other?
    struct Query {
        std::uint32_t task;
        bool outer_is_a;
        ObbTree* tree; ///< of the outer mesh; null where a budget has no room
        bool holds;
    };
    void gather(const RefineContext& context, std::span<const PairTask> tasks, std::span<const std::uint8_t> apart);

    ModelStore& models_;
    std::vector<std::uint8_t> sides_; ///< by task: whose box holds a part of the other; 1: the first's, 2: the second's
    std::vector<Query> queries_;
    std::vector<PointLocator> locators_; ///< by thread
};

} // namespace oncollide
