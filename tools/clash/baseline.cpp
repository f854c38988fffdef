#include "clash/baseline.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>

namespace oncollide::tools {
namespace {

using nlohmann::json;

constexpr std::uintmax_t most_bytes = std::uintmax_t(1) << 30;

struct OldClash {
    ResolvedClash clash;
    std::string review{}; ///< a status that a user wrote
    bool counts = true;   ///< it was a clash, not a contact and not ignored
    bool resolved = false;
    bool found = false; ///< it still exists
};

std::string name_in(const json& part)
{
    return part.is_string() ? part.get<std::string>() : part.at("name").get<std::string>();
}

OldClash old_clash(const json& j, const char* default_status)
{
    OldClash old{.clash = {.id = j.value("id", ""),
                           .a = name_in(j.at("a")),
                           .b = name_in(j.at("b")),
                           .kind = j.at("kind").get<std::string>(),
                           .comment = j.value("comment", "")}};
    const auto status = default_status ? j.value("status", default_status) : j.at("status").get<std::string>();
    old.resolved = status == "resolved" || status == "fixed";
    old.counts = status != "ignored" && status != "contact";
    const bool own = status == "new" || status == "active" || status == "same" || old.resolved || !old.counts;
    if (!own) old.review = status;
    return old;
}

std::vector<OldClash> read_report(const std::string& file)
{
    const auto refuse_report = [&](const std::string& why) {
        refuse(file, fmt::format("{}; expected a JSON report of 'oncollide clash'", why));
    };
    std::vector<OldClash> clashes;
    try {
        const json report = json::parse(read_file(file, most_bytes));
        if (!report.is_object() || report.value("report", "") != "oncollide clash")
            refuse_report("is not a clash report");
        for (const json& clash : report.at("clashes")) clashes.push_back(old_clash(clash, nullptr));
        for (const json& clash : report.value("resolved", json::array()))
            clashes.push_back(old_clash(clash, "resolved"));
    } catch (const json::exception& fault) {
        refuse_report(fault.what());
    }
    return clashes;
}

int rank(std::string_view kind)
{
    return kind == "near" ? 0 : kind == "touching" ? 1 : 2;
}

using Names = std::pair<std::string, std::string>;
Names in_order(const std::string& a, const std::string& b)
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
    std::map<Names, OldClash*> by_names;
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

std::vector<ResolvedClash> compare_with_baseline(const std::string& file, const PartList& list,
                                                 std::vector<Clash>& clashes)
{
    std::vector<OldClash> before = read_report(file);
    const std::vector<OldClash*> matches = matches_of(clashes, list, before);
    for (std::size_t i = 0; i < clashes.size(); ++i) {
        if (!matches[i]) continue;
        compare(clashes[i], *matches[i]);
        // A clash that only touches now is resolved; one that is ignored now is not.
        matches[i]->found |= clashes[i].status != ClashStatus::contact;
    }
    std::vector<ResolvedClash> resolved;
    for (OldClash& old : before)
        if (!old.found && old.counts) resolved.push_back(std::move(old.clash));
    std::ranges::sort(resolved, {}, [](const ResolvedClash& c) { return std::tie(c.a, c.b, c.id); });
    return resolved;
}

} // namespace oncollide::tools
