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

void PairCache::begin_frame(std::span<const BodyPair> pairs, std::span<const std::uint8_t> changed,
                            std::span<const std::uint8_t> fresh)
{
    ONCOLLIDE_ASSERT(std::ranges::is_sorted(pairs));
    pairs_.swap(last_pairs_), rows_.swap(last_rows_);
    pairs_.assign(pairs.begin(), pairs.end());
    rows_.clear(), unchanged_.clear();
    const auto has = [](std::span<const std::uint8_t> marks, BodyPair pair) {
        return !marks.empty() && (marks[pair.a] | marks[pair.b]);
    };
    const std::size_t count = pairs.size(), last_count = last_pairs_.size();
    for (std::size_t i = 0, k = 0; i < count || k < last_count;) {
        const std::size_t begin = i;
        while (i < count && k < last_count && pairs[i] == last_pairs_[k] && !has(changed, pairs[i])) ++i, ++k;
        if (const auto same = static_cast<std::ptrdiff_t>(i - begin)) {
            const auto last = last_rows_.begin() + static_cast<std::ptrdiff_t>(k);
            rows_.insert(rows_.end(), last - same, last);
            unchanged_.push_back({static_cast<std::uint32_t>(begin),
                                  static_cast<std::uint32_t>(k - static_cast<std::size_t>(same)),
                                  static_cast<std::uint32_t>(same)});
        } else if (k < last_count && (i == count || last_pairs_[k] < pairs[i])) {
            free_.push_back(last_rows_[k++]);
        } else if (k < last_count && last_pairs_[k] == pairs[i]) {
            if (has(fresh, pairs[i])) memories_[last_rows_[k]] = {};
            rows_.push_back(last_rows_[k++]), ++i;
        } else {
            rows_.push_back(make_row()), ++i;
        }
    }
}

std::string PairCache::validate() const
{
    std::uint64_t rows = 0; // sum of hashes: each row is used once or free once. This allocates nothing
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
        const BodyPair pair = pairs_[i];
        const std::uint32_t row = rows_[i];
        const auto fault = [&](const char* what) { return fmt::format("pair ({}, {}): {}", pair.a, pair.b, what); };
        if (pair.a == pair.b || (i > 0 && !(pairs_[i - 1] < pair))) return fault("is not in order");
        if (row >= memories_.size()) return fault("has no memory");
        rows += splitmix(row);
        const PairMemory& memory = memories_[row];
        if (std::isnan(memory.apart_until) || std::isnan(memory.meet_until) || !(memory.walked_at >= -1))
            return fault("remembers a distance that is not a number");
    }
    for (std::uint32_t row : free_) rows += splitmix(row);
    for (std::uint32_t row = 0; row < memories_.size(); ++row) rows -= splitmix(row);
    return rows == 0 && rows_.size() + free_.size() == memories_.size() ? "" : "a row is lost or used twice";
}

} // namespace oncollide
