#pragma once
#include <cstdint>
#include <span>

#include <oncollide/broadphase/body_states.hpp>
#include <oncollide/broadphase/tree/aabb_tree.hpp>

namespace oncollide {

/// Tracks whether layers, masks or groups forbid any pair at all; passes the filters that forbid some on to the tree.
class PairFilter {
public:
    /// Applies changes. `changed` includes all bodies that are new or whose layers, mask or group changed. Cost:
    /// O(changed), or O(n) if nothing is known yet.
    void update(const BodyStates& bodies, std::span<const std::uint32_t> changed, const BodyColumns& columns,
                AabbTree& tree);
    void forget() { known_ = false; } ///< call after the tree was rebuilt
    ForbiddingFilters forbidding() const { return {some_in_none_ || (layers_ & ~common_mask_) != 0, groups_}; }

private:
    void add(std::uint32_t body, const BodyColumns& columns);

    bool known_ = false, with_layers_ = false, with_groups_ = false; ///< whether the columns had them
    std::uint32_t layers_ = 0, common_mask_ = ~0u;                   ///< union of layers; intersection of masks
    bool some_in_none_ = false;                                      ///< true if some body is in no layer
    bool groups_ = false;                                            ///< true if some body is in a group
};

} // namespace oncollide
