#include <oncollide/pipeline/refine/pair_cache.hpp>

namespace oncollide {

std::uint32_t PairCache::make_row()
{
    if (free_.empty()) {
        memories_.emplace_back();
        return static_cast<std::uint32_t>(memories_.size() - 1);
    }
    const std::uint32_t row = free_.back();
    free_.pop_back();
    memories_[row] = {};
    return row;
}

void PairCache::begin_frame(std::span<const BodyPair> pairs, std::span<const std::uint8_t> fresh)
{
    now_.swap(before_);
    now_.clear(), earlier_.clear();
    auto last = before_.begin();
    for (const BodyPair pair : pairs) {
        for (; last != before_.end() && last->pair < pair; ++last) free_.push_back(last->row);
        if (last == before_.end() || last->pair != pair) {
            now_.push_back({pair, make_row()}), earlier_.push_back(none);
            continue;
        }
        const bool is_void = !fresh.empty() && (fresh[pair.a] || fresh[pair.b]);
        if (is_void) memories_[last->row] = {};
        earlier_.push_back(is_void ? none : static_cast<std::uint32_t>(last - before_.begin()));
        now_.push_back(*last++);
    }
    for (; last != before_.end(); ++last) free_.push_back(last->row);
}

} // namespace oncollide
