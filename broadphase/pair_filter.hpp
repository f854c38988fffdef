#pragma once
#include <cstdint>
#include <span>

#include <oncollide/broadphase/body_states.hpp>
#include <oncollide/broadphase/box_tree.hpp>

namespace oncollide {

/// Whether layers, masks and groups forbid any pair at all; where layers do, the tree knows them.
class PairFilter {
public:
    /// Takes in bodies, all those among them that are new or of other layers, masks or groups. Cost: O(changed), or
    /// O(n) where nothing is known.
    void update(const BodyStates& bodies, std::span<const std::uint32_t> changed, const BodyColumns& columns,
                BoxTree& tree);
    void forget() { known_ = false; } ///< the tree was built anew
    bool layers_forbid() const { return some_in_none_ || (layers_ & ~common_mask_) != 0; }
    bool forbids() const { return layers_forbid() || groups_; }

private:
    void add(std::uint32_t body, const BodyColumns& columns);

    bool known_ = false, with_layers_ = false, with_groups_ = false; ///< as the columns were
    std::uint32_t layers_ = 0, common_mask_ = ~0u;                   ///< in some body's layers; in every body's mask
    bool some_in_none_ = false;                                      ///< is there a body in no layer?
    bool groups_ = false;                                            ///< is there a body in a group?
};

} // namespace oncollide
