#pragma once
#include <cstdint>

namespace oncollide {

/// One stored cell: 8 bytes. Its level, position and sphere follow from the path to it.
struct OcstNode {
    std::uint32_t first_child = 0; ///< first of its grey children, packed in octant order; unused on the last stored
                                   ///< level
    std::uint32_t state = 0;       ///< bits 0-7 grey mask, bit 8 expanded, bits 9-31 the frame that last reached it

    static constexpr std::uint32_t expanded_bit = 1u << 8;
    static constexpr int stamp_shift = 9;
    static constexpr std::uint32_t stamp_mask = (1u << 23) - 1;

    unsigned grey() const { return state & 0xff; }
    bool expanded() const { return state & expanded_bit; }
    std::uint32_t stamp() const { return state >> stamp_shift; }
};

} // namespace oncollide
