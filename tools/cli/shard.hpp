#pragma once
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace oncollide::tools {

/// A part of work that is divided among independent processes: part `part` of `parts`, from 1. All of it: 1 of 1.
struct Shard {
    int part = 1, parts = 1;

    bool whole() const { return parts == 1; }
    /// Which of `count` items are its: first and end. The parts cover all, in order.
    std::pair<std::size_t, std::size_t> range(std::size_t count) const
    {
        const auto end = [&](int k) { return count * std::size_t(k) / std::size_t(parts); };
        return {end(part - 1), end(part)};
    }
    /// The first line of its file, by which `oncollide merge` knows it; empty for all of the work.
    /// @param work  what is divided, the same in all parts: text without line breaks
    std::string line(const std::string& work) const;
};

/// Keeps the shard's part of `items`, called `what`. Throws Error{usage} where there are fewer of them than parts.
void check_parts(const Shard& shard, std::size_t items, const char* what);
template <class Item>
void keep_part(const Shard& shard, std::vector<Item>& items, const char* what)
{
    check_parts(shard, items.size(), what);
    const auto [first, end] = shard.range(items.size());
    items.erase(items.begin() + std::ptrdiff_t(end), items.end());
    items.erase(items.begin(), items.begin() + std::ptrdiff_t(first));
}

/// From "3/8"; empty: all of the work. Throws Error{usage}.
Shard shard_from(const std::string& text);

/// What is said of every --shard.
inline constexpr const char* shard_help =
    "do part I of N alone; 'oncollide merge' makes of the N files what one process would have written";

} // namespace oncollide::tools
