#include <oncollide/pipeline/refine/pair_cache.hpp>

#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/numbers/random.hpp>

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
    ONCOLLIDE_ASSERT(std::ranges::is_sorted(pairs));
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

std::string PairCache::validate() const
{
    std::uint64_t rows = 0; // sum of hashes: each row is used once or free once. This allocates nothing
    for (std::size_t i = 0; i < now_.size(); ++i) {
        const auto& [pair, row] = now_[i];
        const auto fault = [&](const char* what) { return fmt::format("pair ({}, {}): {}", pair.a, pair.b, what); };
        if (pair.a >= pair.b || (i > 0 && !(now_[i - 1].pair < pair))) return fault("is not in order");
        if (row >= memories_.size()) return fault("has no memory");
        rows += splitmix(row);
        const PairMemory& memory = memories_[row];
        if (std::isnan(memory.apart_until) || std::isnan(memory.meet_until) || !(memory.walked_at >= -1))
            return fault("remembers a distance that is not a number");
    }
    for (std::uint32_t row : free_) rows += splitmix(row);
    for (std::uint32_t row = 0; row < memories_.size(); ++row) rows -= splitmix(row);
    return rows == 0 && now_.size() + free_.size() == memories_.size() ? "" : "a row is lost or used twice";
}

} // namespace oncollide
