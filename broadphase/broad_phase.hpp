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

/// An algorithm that finds the overlapping boxes among some bodies. It may keep what it knows from call to call.
class BroadPhase {
public:
    virtual ~BroadPhase() = default;
    virtual std::string_view name() const = 0;

    /// Pairs of `bodies` whose boxes, each grown by `margin` / 2 on all sides, overlap, and that `filter` allows;
    /// sorted, each once. Octree and brute force may hold pairs whose boxes miss each other by less than 2^-21 of the
    /// scene's extent (boxes are compared in float, rounded outward); none ever lacks one.
    ///
    /// @param boxes   world boxes by body, metres, closed
    /// @param bodies  which bodies take part, each once
    /// @param margin  metres, >= 0
    /// @param pairs   overwritten
    /// The list is the same for any thread count. Allocates nothing once warm.
    virtual void find_pairs(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies,
                            const BodyFilter& filter, double margin, int threads, std::vector<BodyPair>& pairs) = 0;

    /// Does update_pairs() cost less than find_pairs() when few bodies move?
    virtual bool follows_movers() const { return false; }
    /// The same, when only the boxes of `moved` differ from the last call, which had the same bodies, filter and margin
    /// and gave `pairs`.
    /// @param asked  those of `moved` that may be in a pair now
    virtual void update_pairs(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies,
                              [[maybe_unused]] std::span<const std::uint32_t> moved,
                              [[maybe_unused]] std::span<const std::uint32_t> asked, const BodyFilter& filter,
                              double margin, int threads, std::vector<BodyPair>& pairs)
    {
        find_pairs(boxes, bodies, filter, margin, threads, pairs);
    }
    virtual std::size_t bytes() const { return 0; } ///< held from call to call
};

/// kd-tree: boxes in kd order under an implicit 16-ary tree of bounds (BoxTree), searched against itself. The order
/// stays from call to call while bodies move little. Cost: O(n + pairs) a call, O(n log n) where the order is made
/// anew; update_pairs() of few bodies O(moved + pairs).
std::unique_ptr<BroadPhase> make_kd_tree();

/// Octree: split at the mean centre along all three axes at once; boxes that straddle any of them stay at the inner
/// node.
std::unique_ptr<BroadPhase> make_octree();

/// Every pair of boxes. The reference. Cost: O(n^2).
std::unique_ptr<BroadPhase> make_brute_force();

} // namespace oncollide
