#include "clash/grouping.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include <fmt/format.h>

#include "cli/arguments.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

constexpr std::array group_keys{GroupKey::part_class, GroupKey::storey, GroupKey::discipline, GroupKey::part};

std::vector<ClashGroup> by_text(const PartList& list, const std::vector<Clash>& clashes,
                                std::span<const std::size_t> rows, GroupKey key)
{
    std::vector<ClashGroup> groups;
    std::map<std::string, std::size_t> numbers;
    for (const std::size_t row : rows) {
        const std::string text = text_of(key, list, clashes[row]);
        const auto [at, is_new] = numbers.emplace(text, groups.size());
        if (is_new) groups.push_back({text, {}});
        groups[at->second].rows.push_back(row);
    }
    return groups;
}

std::vector<ClashGroup> by_part(const PartList& list, const std::vector<Clash>& clashes,
                                std::span<const std::size_t> rows)
{
    std::map<std::uint32_t, std::vector<std::size_t>> of_part;
    for (const std::size_t row : rows) of_part[clashes[row].a].push_back(row), of_part[clashes[row].b].push_back(row);
    std::map<std::uint32_t, std::size_t> left; // clashes that are in no group
    std::set<std::pair<std::ptrdiff_t, std::uint32_t>> most_first;
    for (const auto& [part, its] : of_part)
        left[part] = its.size(), most_first.emplace(-std::ptrdiff_t(its.size()), part);
    std::set<std::size_t> grouped_rows;
    std::vector<ClashGroup> groups;
    while (grouped_rows.size() < rows.size()) {
        const std::uint32_t part = most_first.begin()->second;
        ClashGroup& group = groups.emplace_back(ClashGroup{list.parts[part].label, {}});
        for (const std::size_t row : of_part[part]) {
            if (!grouped_rows.insert(row).second) continue;
            group.rows.push_back(row);
            for (const std::uint32_t of : {clashes[row].a, clashes[row].b}) {
                most_first.erase({-std::ptrdiff_t(left[of]), of});
                most_first.emplace(-std::ptrdiff_t(--left[of]), of);
            }
        }
    }
    return groups;
}

} // namespace

std::string_view name_of(GroupKey key)
{
    constexpr std::string_view names[] = {"class", "storey", "discipline", "part"};
    return names[static_cast<int>(key)];
}

std::vector<GroupKey> group_keys_from(const std::string& text)
{
    std::vector<GroupKey> keys;
    if (text.empty()) return keys;
    for (const std::string& name : split(text)) {
        const auto* const key = std::ranges::find(group_keys, name, [](GroupKey k) { return name_of(k); });
        if (key == group_keys.end() || std::ranges::count(keys, *key))
            usage(fmt::format("--group-by {}: expected some of class, storey, discipline, part, each once", text));
        keys.push_back(*key);
    }
    return keys;
}

std::string text_of(GroupKey key, const Part& part)
{
    const PartDetails& d = part.details;
    std::string text = key == GroupKey::part_class ? class_text(d.part_class)
                       : key == GroupKey::storey   ? d.storey
                       : key == GroupKey::part     ? part.label
                                                   : d.discipline;
    return text.empty() ? fmt::format("without {}", name_of(key)) : text;
}

std::string text_of(GroupKey key, const PartList& list, const Clash& clash)
{
    std::string a = text_of(key, list.parts[clash.a]), b = text_of(key, list.parts[clash.b]);
    if (a == b) return a;
    if (!list.has_sets && b < a) std::swap(a, b);
    return fmt::format("{} and {}", a, b);
}

std::vector<ClashGroup> groups_of(const PartList& list, const std::vector<Clash>& clashes,
                                  std::span<const std::size_t> rows, const std::vector<GroupKey>& keys)
{
    std::vector<ClashGroup> groups{{"", {rows.begin(), rows.end()}}};
    for (const GroupKey key : keys) {
        std::vector<ClashGroup> finer;
        for (const ClashGroup& group : groups)
            for (ClashGroup& part :
                 key == GroupKey::part ? by_part(list, clashes, group.rows) : by_text(list, clashes, group.rows, key)) {
                if (!group.name.empty()) part.name = group.name + ", " + part.name;
                finer.push_back(std::move(part));
            }
        groups = std::move(finer);
    }
    std::erase_if(groups, [](const ClashGroup& group) { return group.rows.empty(); });
    std::ranges::stable_sort(groups, {}, [](const ClashGroup& group) { return group.rows.front(); });
    return groups;
}

} // namespace oncollide::tools
