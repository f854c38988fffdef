#include "clash/baseline.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/text/plain_number.hpp>

namespace oncollide::tools {
namespace {

using nlohmann::json;

constexpr std::uintmax_t most_baseline_bytes = std::uintmax_t(1) << 30;

struct OldClash {
    ResolvedClash clash;
    std::string review{}; ///< a status that a user wrote
    bool counts = true;   ///< it was a clash, not a contact and not ignored
    bool resolved = false;
    bool found = false; ///< it still exists
};

/// @param resolved  the entry is from the list of resolved clashes, which has only the parts' names
OldClash old_clash(const json& j, bool resolved)
{
    const auto name_in = [&](const char* part) {
        return (resolved ? j.at(part) : j.at(part).at("name")).get<std::string>();
    };
    OldClash old{.clash = {.id = j.value("id", ""),
                           .a = name_in("a"),
                           .b = name_in("b"),
                           .kind = j.at("kind").get<std::string>(),
                           .comment = j.value("comment", "")}};
    const auto status = j.at("status").get<std::string>();
    old.resolved = status == "resolved";
    old.counts = status != "ignored" && status != "contact";
    const bool own = status == "new" || status == "active" || old.resolved || !old.counts;
    if (!own) old.review = status;
    return old;
}

struct OldReport {
    std::vector<OldClash> clashes;
    double clearance = 0; ///< millimetres
};

OldReport read_report(const std::string& file)
{
    const auto refuse_report = [&](const std::string& why) {
        refuse(file, fmt::format("{}; expected a JSON report of 'oncollide clash'", why));
    };
    OldReport old;
    try {
        const json report = json::parse(read_file(file, most_baseline_bytes));
        if (!report.is_object() || report.value("schema", "") != "oncollide.clash")
            refuse_report("is not a clash report");
        const Unit* const unit = find_unit(report.value("unit", "mm"));
        if (!unit) refuse_report("has an unknown unit");
        old.clearance = report.value("clearance", 0.0) * unit->millimetres;
        for (const json& clash : report.at("clashes")) old.clashes.push_back(old_clash(clash, false));
        for (const json& clash : report.at("resolved")) old.clashes.push_back(old_clash(clash, true));
    } catch (const json::exception& fault) {
        std::string_view text = fault.what(); // "[json.exception...] why; last read: 'text'", of any kind of file
        text.remove_prefix(std::min(text.find("] "), text.size() - 2) + 2);
        refuse_report(fmt::format("not a valid report: {}", text.substr(0, text.find("; last read"))));
    }
    return old;
}

int rank(std::string_view kind)
{
    return kind == "near" ? 0 : kind == "touching" || kind == "within" ? 1 : 2;
}

using NamesOfPair = std::pair<std::string, std::string>;
NamesOfPair in_order(const std::string& a, const std::string& b)
{
    return {std::min(a, b), std::max(a, b)};
}

/// The old clash of each clash, or null: by ids, then for the rest by the names of the parts.
std::vector<OldClash*> matches_of(const std::vector<Clash>& clashes, const PartList& list,
                                  std::vector<OldClash>& before)
{
    std::map<std::string, OldClash*> by_id;
    for (OldClash& old : before)
        if (!old.clash.id.empty()) by_id.emplace(old.clash.id, &old);
    std::vector<OldClash*> matches;
    std::set<const OldClash*> taken;
    for (const Clash& clash : clashes) {
        const auto at = by_id.find(clash.id);
        matches.push_back(at != by_id.end() ? at->second : nullptr);
        taken.insert(matches.back());
    }
    std::map<NamesOfPair, OldClash*> by_names;
    for (OldClash& old : before)
        if (!taken.contains(&old)) by_names.emplace(in_order(old.clash.a, old.clash.b), &old);
    for (std::size_t i = 0; i < clashes.size(); ++i) {
        if (matches[i]) continue;
        const auto at = by_names.find(in_order(list.parts[clashes[i].a].name, list.parts[clashes[i].b].name));
        if (at != by_names.end()) matches[i] = at->second;
    }
    return matches;
}

void compare(Clash& clash, const OldClash& old)
{
    clash.comment = old.clash.comment;
    if (clash.status != ClashStatus::fresh || !old.counts || old.resolved) return;
    if (rank(old.clash.kind) < rank(name_of(clash.kind))) {
        clash.was = old.clash.kind;
        return;
    }
    clash.status = ClashStatus::active, clash.review = old.review;
}

} // namespace

std::vector<ResolvedClash> compare_with_baseline(const std::string& file, const PartList& list, double clearance,
                                                 const Unit& unit, std::vector<Clash>& clashes,
                                                 std::vector<std::string>& warnings)
{
    auto [before, old_clearance] = read_report(file);
    old_clearance /= unit.millimetres;
    if (old_clearance > clearance * (1 + 1e-9))
        warnings.push_back(fmt::format("{}: has a clearance of {} {}, now it is {} {}: pairs farther apart "
                                       "count as resolved",
                                       file, plain_measure(old_clearance, 6), unit.name, plain_measure(clearance, 6),
                                       unit.name));
    const std::vector<OldClash*> matches = matches_of(clashes, list, before);
    for (std::size_t i = 0; i < clashes.size(); ++i) {
        if (!matches[i]) continue;
        compare(clashes[i], *matches[i]);
        // A clash that only touches now is resolved; a clash that is ignored now is not resolved.
        matches[i]->found |= clashes[i].status != ClashStatus::contact;
    }
    std::vector<ResolvedClash> resolved;
    for (OldClash& old : before)
        if (!old.found && old.counts) resolved.push_back(std::move(old.clash));
    std::ranges::sort(resolved, {}, [](const ResolvedClash& c) { return std::tie(c.a, c.b, c.id); });
    return resolved;
}

} // namespace oncollide::tools
