#include "clash/matrix.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>

#include "clash/parts/name_pattern.hpp"

namespace oncollide::tools {
namespace {

constexpr std::uintmax_t most_matrix_bytes = std::uintmax_t(1) << 24;

} // namespace

ClashMatrix::ClashMatrix(const std::string& file, const Unit& unit)
{
    const auto json = nlohmann::json::parse(read_file(file, most_matrix_bytes), nullptr, false);
    const std::string form =
        R"(expected {"by": "discipline", "rules": [{"a": "MEP*", "b": "STR*", "clearance": "50mm"}]})";
    const auto fail = [&](const std::string& why) { refuse(file, fmt::format("{}; {}", why, form)); };
    if (!json.is_object() || !json.contains("rules") || !json["rules"].is_array()) fail("not a clash matrix");
    for (const auto& [key, value] : json.items())
        if (key != "by" && key != "rules") fail(fmt::format("unknown key '{}'", key));
    const auto by = json.value("by", nlohmann::json("discipline"));
    if (by == "discipline")
        by_ = GroupKey::discipline;
    else if (by == "class")
        by_ = GroupKey::part_class;
    else if (by == "storey")
        by_ = GroupKey::storey;
    else
        fail(fmt::format("\"by\" is {}; valid: discipline, class, storey", by.dump()));
    for (const auto& entry : json["rules"]) {
        const std::string name = fmt::format("rules[{}]", rules_.size());
        if (!entry.is_object()) fail(name + " is not an object");
        Rule& rule = rules_.emplace_back();
        for (const auto& [key, value] : entry.items()) {
            const bool length = key == "clearance" || key == "tolerance";
            if ((key == "a" || key == "b") && value.is_string())
                (key == "a" ? rule.a : rule.b) = value.get<std::string>();
            else if (length && (value.is_string() || value.is_number())) {
                double& limit = key == "clearance" ? rule.clearance : rule.tolerance;
                try {
                    limit = length_from(key, value.is_string() ? value.get<std::string>() : value.dump(), unit);
                } catch (const Error& error) {
                    refuse(file, fmt::format("{}: {}", name, error.what()));
                }
            } else if (key == "skip" && value.is_boolean())
                rule.skip = value.get<bool>();
            else
                fail(fmt::format(
                    "{} has '{}': {}; valid: a, b (patterns), clearance, tolerance (lengths), skip (true or "
                    "false)",
                    name, key, value.dump()));
        }
        if (rule.a.empty() || rule.b.empty()) fail(name + " lacks \"a\" or \"b\"");
    }
}

bool ClashMatrix::fits(const std::string& pattern, const Part& part) const
{
    return matches(pattern, text_of(by_, part)) ||
           (by_ == GroupKey::part_class && matches(pattern, part.details.part_class));
}

PairLimits ClashMatrix::limits(const Part& a, const Part& b, const PairLimits& other) const
{
    for (const Rule& rule : rules_) {
        if (!(fits(rule.a, a) && fits(rule.b, b)) && !(fits(rule.a, b) && fits(rule.b, a))) continue;
        return {rule.clearance < 0 ? other.clearance : rule.clearance,
                rule.tolerance < 0 ? other.tolerance : rule.tolerance, rule.skip};
    }
    return other;
}

double ClashMatrix::largest() const
{
    double most = 0;
    for (const Rule& rule : rules_) most = std::max({most, rule.clearance, rule.tolerance});
    return most;
}

std::vector<std::string> ClashMatrix::idle_rules(const PartList& list) const
{
    std::vector<std::string> idle;
    for (std::size_t i = 0; i < rules_.size(); ++i) {
        const auto any = [&](const std::string& pattern) {
            return std::ranges::any_of(list.parts, [&](const Part& part) { return fits(pattern, part); });
        };
        if (!any(rules_[i].a) || !any(rules_[i].b))
            idle.push_back(fmt::format("rule {} ('{}' and '{}')", i + 1, rules_[i].a, rules_[i].b));
    }
    return idle;
}

} // namespace oncollide::tools
