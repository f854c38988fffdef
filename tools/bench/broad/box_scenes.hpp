#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide::tools {

/// Moving boxes without bodies in them: what the benchmark of the broad phase plays. Deterministic.
struct BoxScene {
    std::string name;
    std::vector<Aabb> boxes;             ///< at `frame`, metres
    std::vector<std::uint32_t> moved;    ///< boxes that changed since the frame before, ascending
    std::vector<std::uint8_t> is_static; ///< by box: never moves, and forms no pair with another static box
    std::uint64_t frame = 0;
    std::uint64_t last_frame = ~std::uint64_t{0}; ///< of a recording
    std::function<void(BoxScene&)> next;          ///< moves the boxes from `frame` - 1 to `frame`
};

void advance(BoxScene& scene);

/// The names that make_box_scene knows.
std::span<const std::string_view> box_scene_names();
/// Frame 0 of a generated scene of `count` boxes. Its corners are multiples of 2^-13, the lower ones even, the upper
/// ones odd, and exact in single precision: no two boxes touch, so that every algorithm has the same answer.
/// Throws Error{usage} for an unknown name or a count outside 1 to most_boxes.
BoxScene make_box_scene(std::string_view name, std::size_t count, std::uint64_t seed);
inline constexpr std::size_t most_boxes = 2'000'000; ///< above, corners of the largest scene would need more than float

/// A set of pairs, for comparison.
struct PairSet {
    std::uint64_t count = 0, hash = 0;
    friend bool operator==(PairSet, PairSet) = default;
};

/// The hash is the sum of splitmix(a << 32 | b) over the pairs, a < b: any order, and the two of a pair may be swapped.
PairSet summarise(std::span<const BodyPair> pairs);

/// What scenes of seed 12345 must give, from an implementation that shares no code with this one.
std::optional<PairSet> published_result(std::string_view scene, std::size_t count, std::uint64_t frame);

// For generators.

/// The box around `position` on the grid that make_box_scene speaks of.
Aabb box_on_grid(const Eigen::Vector3d& position, const Eigen::Vector3d& half);

/// Broadmark's scenes; `motion` is freefall, brownian or gravity, `assorted` its mixture of shapes instead of cubes.
BoxScene make_broadmark_scene(std::string_view motion, bool assorted, std::size_t count, std::uint64_t seed);

} // namespace oncollide::tools
