#include "clash/parts/part_selection.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/text/listed.hpp>

#include "clash/parts/name_pattern.hpp"
#include "cli/arguments.hpp"

namespace oncollide::tools {

bool PartSelection::matches_part(const std::string& pattern, const AssemblyPart& from, const Part& part)
{
    const bool found = matches(pattern, from.name) || matches(pattern, from.path) || matches(pattern, part.path);
    if (found) used_[pattern] = true;
    return found;
}

std::uint32_t PartSelection::numbered(const std::string& key, const std::string& name)
{
    const auto [at, is_new] = numbers_.emplace(key, static_cast<std::uint32_t>(list_.groups.size()));
    if (is_new) list_.groups.push_back(name);
    return at->second;
}

std::uint32_t PartSelection::group_of(const AssemblyPart& from, const Part& part)
{
    std::uint32_t group = 0;
    for (const std::string& rule : rules_.groups) { // all rules are tried, so that each one that matches counts as used
        std::string key = "\n" + rule, name = rule;
        if (rule == "file") {
            key = name = part.file;
        } else if (rule == "node") {
            if (from.above == no_node_above) continue;
            const std::string above = from.path.substr(0, from.path.size() - from.name.size());
            key = fmt::format("{}\n{}", part.file, from.above);
            name = above.empty() ? part.file : above.substr(0, above.size() - 1);
        } else if (!matches_part(rule, from, part)) {
            continue;
        }
        used_[rule] = true;
        if (!group) group = numbered(key, name);
    }
    return group;
}

void PartSelection::choose(const AssemblyPart& from, Part& part)
{
    part.group = group_of(from, part);
    const auto in = [&](const std::vector<std::string>& patterns) {
        bool any = false;
        for (const std::string& pattern : patterns) any |= matches_part(pattern, from, part);
        return any;
    };
    const bool in_a = in(rules_.set_a), in_b = rules_.set_b.empty() ? !in_a : in(rules_.set_b);
    part.sets = static_cast<std::uint8_t>((in_a ? 1 : 0) | (in_b ? 2 : 0));
}

namespace {

/// The parts of one group that are on one side of the comparison.
struct PartKind {
    std::uint32_t group;
    std::uint8_t sets;
    auto operator<=>(const PartKind&) const = default;
};

/// True if parts of both kinds are compared; without sets, all parts are in both.
bool compared(const PartKind& a, const PartKind& b, bool has_sets)
{
    const bool crosses = (a.sets & 1 && b.sets & 2) || (a.sets & 2 && b.sets & 1);
    return (a.group == 0 || a.group != b.group) && (!has_sets || crosses);
}

} // namespace

void PartSelection::check_pairs() const
{
    std::map<PartKind, std::size_t> kinds;
    std::size_t in_a = 0, in_b = 0, in_both = 0;
    for (const Part& part : list_.parts) {
        ++kinds[{part.group, part.sets}];
        in_a += part.sets & 1, in_b += (part.sets & 2) / 2, in_both += part.sets == 3;
    }
    for (auto a = kinds.begin(); a != kinds.end(); ++a)
        for (auto b = a; b != kinds.end(); ++b)
            if (compared(a->first, b->first, list_.has_sets) && (a != b || a->second > 1)) return;
    const std::string all = fmt::format("of {} parts", list_.parts.size());
    if (list_.has_sets && in_a == 0)
        usage(fmt::format("--set-a {}: matches none {}, so nothing is compared", listed(rules_.set_a), all));
    if (list_.has_sets && in_b == 0)
        usage(rules_.set_b.empty()
                  ? fmt::format("--set-a {}: matches all {}, so no part is left for the other set and nothing is "
                                "compared; give --set-b",
                                listed(rules_.set_a), all.substr(3))
                  : fmt::format("--set-b {}: matches none {}, so nothing is compared", listed(rules_.set_b), all));
    if (in_both == 1 && in_a == 1 && in_b == 1)
        usage(fmt::format("--set-a and --set-b: both match the same one {}, so nothing is compared", all));
    usage(fmt::format("--group: no two {} are compared, since they are of one group{}", all,
                      list_.has_sets ? " or of one set" : ""));
}

void PartSelection::finish()
{
    check_pairs();
    const std::string example = fmt::format("the path of the first part is '{}'", list_.parts.front().path);
    for (const auto& [option, patterns] : {std::pair("--set-a", rules_.set_a), std::pair("--set-b", rules_.set_b)})
        for (const std::string& pattern : patterns)
            if (!used_.contains(pattern)) usage(fmt::format("{} '{}': matches no part; {}", option, pattern, example));
    for (const std::string& rule : rules_.groups) {
        if (used_.contains(rule)) continue;
        const std::string text = rule == "node" ? "--group node: no part is below a node of an assembly"
                                                : fmt::format("--group '{}' matches no part", rule);
        if (rules_.strict) usage(text + "; " + example);
        list_.warnings.push_back(text);
    }
}

} // namespace oncollide::tools
