#pragma once
#include <optional>
#include <vector>

#include <oncollide/narrowphase/exact/point_place.hpp>
#include <oncollide/narrowphase/exact/solid.hpp>
#include <oncollide/pipeline/forest.hpp>
#include <oncollide/pipeline/frame.hpp>

namespace oncollide {

/// Solid mode: finds the pairs of which one body is inside the other, or a part of it, their surfaces being apart.
class ContainmentTest {
public:
    explicit ContainmentTest(Forest& forest) : forest_(forest) {}

    /// Among the results of stage `stage` that say that surfaces do not meet: those that enclose become colliding.
    /// In surface mode there are none. Returns how many were separate before.
    std::uint64_t find(const Scene& scene, Frame& frame, std::uint8_t stage);

private:
    /// Does body `outer` hold body `inner`? To be found out.
    struct Question {
        std::uint32_t result, outer, inner;
        ObbTree* tree; ///< of the outer mesh; null where a budget has no room
        bool yes;
    };
    void ask(const Scene& scene, const Frame& frame, std::uint8_t stage);
    bool holds(const Scene& scene, const Question& question, PointLocator& locator) const;

    Forest& forest_;
    std::vector<std::uint8_t>
        sides_; ///< by result: whose box holds a part of the other; 1: the first's, 2: the second's
    std::vector<Question> questions_;
    std::vector<PointLocator> locators_; ///< by thread
};

} // namespace oncollide
