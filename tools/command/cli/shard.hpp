#pragma once
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace oncollide::tools {

/// A part of work that is divided among independent processes: part `part` of `parts`, from 1. The whole is 1 of 1.
struct Shard {
    int part = 1, parts = 1;

    bool whole() const { return parts == 1; }
    /// The range [first, end) of its items, out of `count`. The parts cover all items, in order.
    std::pair<std::size_t, std::size_t> range(std::size_t count) const
    {
        const auto end = [&](int k) { return count * std::size_t(k) / std::size_t(parts); };
        return {end(part - 1), end(part)};
    }
    /// The first line of its file, which `oncollide merge` reads; empty for the whole.
    /// @param work  describes the divided work, equal in all parts; written as printable() writes it
    std::string line(const std::string& work) const;
};

/// Keeps the shard's part of `items`, called `what` in messages. Throws Error{usage} if there are fewer items than
/// parts.
void check_parts(const Shard& shard, std::size_t items, const char* what);
template <class Item>
void keep_part(const Shard& shard, std::vector<Item>& items, const char* what)
{
    check_parts(shard, items.size(), what);
    const auto [first, end] = shard.range(items.size());
    items.erase(items.begin() + std::ptrdiff_t(end), items.end());
    items.erase(items.begin(), items.begin() + std::ptrdiff_t(first));
}

/// Parses "3/8"; empty: the whole. Throws Error{usage}.
Shard shard_from(const std::string& text);

/// Help text of every --shard.
inline constexpr const char* shard_help =
    "compute only part I of N; 'oncollide merge' joins the N files into the file of a single process";

} // namespace oncollide::tools
