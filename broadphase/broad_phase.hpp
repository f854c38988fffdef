#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// Two bodies that may collide; a < b.
struct BodyPair {
    std::uint32_t a, b;
    friend bool operator==(BodyPair, BodyPair) = default;
    friend auto operator<=>(BodyPair, BodyPair) = default;
};

/// What decides, before any box is compared, whether two bodies may form a pair. Columns by body.
struct BodyFilter {
    std::span<const std::uint8_t> is_static;
    std::span<const std::uint32_t> layers, masks;

    bool allows(std::uint32_t a, std::uint32_t b) const
    {
        return !(is_static[a] && is_static[b]) && (layers[a] & masks[b]) && (layers[b] & masks[a]);
    }
};

/// What delimitation did at one level of its hierarchy of regions, level 0 being the whole scene. A region counts where
/// the one around it was not rejected.
struct DelimitationLevel {
    std::uint64_t regions = 0;          ///< regions looked at
    std::uint64_t regions_rejected = 0; ///< of these, regions in which nothing can collide
    std::uint64_t bodies_rejected = 0;  ///< bodies in them
    double volume_rejected = 0;         ///< share of the volume of all the level's regions out of play, 0 to 1
    double ms = 0;                      ///< time spent on the level
};

/// An algorithm that finds the overlapping boxes among some bodies. It may keep what it knows from call to call.
class BroadPhase {
public:
    virtual ~BroadPhase() = default;
    virtual std::string_view name() const = 0;

    /// Pairs of `bodies` whose boxes, each grown by `margin` / 2 on all sides, overlap, and that `filter` allows;
    /// sorted, each once. Boxes are compared in float, rounded outward; where that leaves a doubt, in double.
    ///
    /// @param boxes   world boxes by body, metres, closed
    /// @param bodies  which bodies take part, each once
    /// @param margin  metres, >= 0
    /// @param pairs   overwritten
    /// Throws Error{bad_data} naming the body if a coordinate is not finite or beyond 1e30 m.
    /// The list is the same for any thread count. Allocates nothing once warm.
    virtual void find_pairs(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies,
                            const BodyFilter& filter, double margin, int threads, std::vector<BodyPair>& pairs) = 0;
    virtual std::size_t bytes() const { return 0; } ///< held from call to call
};

/// kd-tree: boxes in kd order under an implicit 16-ary tree of bounds (BoxTree), searched against itself. The order
/// stays from call to call while bodies move little. Cost: O(n + pairs) a call, O(n log n) where the order is made
/// anew. Where few bodies move, DynamicTree costs less.
std::unique_ptr<BroadPhase> make_kd_tree();

/// Octree: the same tree over boxes in the order of an octree's cells. Its order costs a third of the kd-tree's to
/// make and a search of it somewhat more: it wins where bodies jump.
std::unique_ptr<BroadPhase> make_octree();

/// Every pair of boxes. The reference. Cost: O(n^2).
std::unique_ptr<BroadPhase> make_brute_force();

} // namespace oncollide
