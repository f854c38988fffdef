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

/// Moving boxes without bodies: the workload of the broad phase benchmark. Deterministic.
struct BoxScene {
    std::string name;
    std::vector<Aabb> boxes;             ///< at `frame`, metres
    std::vector<std::uint32_t> moved;    ///< boxes that changed since the previous frame, ascending
    std::vector<std::uint8_t> is_static; ///< by box: never moves, and forms no pair with another static box
    std::uint64_t frame = 0;
    std::uint64_t last_frame = ~std::uint64_t{0}; ///< last frame of a recording
    std::function<void(BoxScene&)> next;          ///< moves the boxes from `frame` - 1 to `frame`
};

void advance(BoxScene& scene);

/// The names for make_box_scene().
std::span<const std::string_view> box_scene_names();
/// Frame 0 of a generated scene of `count` boxes. Coordinates are multiples of 2^-13, even for lower corners, odd for
/// upper ones, and exact in single precision: no two boxes touch, so every algorithm has the same result.
/// Throws Error{usage} for an unknown name or a count outside 1 to most_boxes.
BoxScene make_box_scene(std::string_view name, std::size_t count, std::uint64_t seed);
inline constexpr std::size_t most_boxes = 2'000'000; ///< more boxes would need coordinates beyond single precision

/// A set of pairs, for comparison.
struct PairSet {
    std::uint64_t count = 0, hash = 0;
    friend bool operator==(PairSet, PairSet) = default;
};

/// The hash is the sum of splitmix(a << 32 | b) over the pairs, a < b. It does not depend on the order of pairs or
/// bodies.
PairSet summarise(std::span<const BodyPair> pairs);

/// Expected results of scenes with seed 12345, from an implementation that shares no code with this one.
std::optional<PairSet> published_result(std::string_view scene, std::size_t count, std::uint64_t frame);

// Functions for generators.

/// The box around `position`, rounded to the grid of make_box_scene().
Aabb box_on_grid(const Eigen::Vector3d& position, const Eigen::Vector3d& half);

/// Broadmark's scenes; `motion` is freefall, brownian or gravity; `assorted` selects its mixture of shapes in place of
/// cubes.
BoxScene make_broadmark_scene(std::string_view motion, bool assorted, std::size_t count, std::uint64_t seed);

} // namespace oncollide::tools
