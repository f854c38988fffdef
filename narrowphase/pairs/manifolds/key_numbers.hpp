// Consecutive numbers for keys.
#pragma once
#include <bit>
#include <cstdint>
#include <vector>

namespace oncollide {

/// Gives keys the numbers 0, 1, 2, ... in the order of their first use. A hash table that keeps its memory: a manifold
/// uses several, each for a few hundred keys.
class KeyNumbers {
public:
    static constexpr std::uint32_t none = ~0u;

    void clear()
    {
        const int bits = std::max<int>(6, std::bit_width(2ull * count_)); // as large as its last use needed
        slots_.assign(std::size_t{1} << bits, {}), shift_ = 64 - bits, count_ = 0;
    }
    std::uint32_t count() const { return count_; }
    /// Returns the key's number. A new key gets the number count() - 1, and sets `is_new`.
    std::uint32_t add(std::uint64_t key, bool& is_new)
    {
        if (2 * std::size_t{count_} >= slots_.size()) grow();
        Slot& slot = slot_of(key);
        is_new = slot.number == none;
        if (is_new) slot = {key, count_++};
        return slot.number;
    }
    std::uint32_t find(std::uint64_t key) const { return const_cast<KeyNumbers*>(this)->slot_of(key).number; }

private:
    struct Slot {
        std::uint64_t key = 0;
        std::uint32_t number = none;
    };
    /// The key's slot, or the free one for it.
    Slot& slot_of(std::uint64_t key)
    {
        std::size_t at = key * 0x9E3779B97F4A7C15 >> shift_;
        while (slots_[at].number != none && slots_[at].key != key) at = (at + 1) & (slots_.size() - 1);
        return slots_[at];
    }
    void grow()
    {
        before_.swap(slots_);
        const std::size_t size = std::max<std::size_t>(64, 2 * before_.size());
        slots_.assign(size, {}), shift_ = 64 - std::countr_zero(size);
        for (const Slot& slot : before_)
            if (slot.number != none) slot_of(slot.key) = slot;
        before_.clear();
    }

    std::vector<Slot> slots_, before_;
    int shift_ = 0;
    std::uint32_t count_ = 0;
};

} // namespace oncollide
