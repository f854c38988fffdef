#include "clash/known_pairs.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/text/csv_reader.hpp>

#include "clash/name_pattern.hpp"

namespace oncollide::tools {
namespace {

constexpr std::uintmax_t most_bytes = std::uintmax_t(1) << 30;

struct KnownPair {
    std::string a, b;
    std::size_t line;
};

std::vector<KnownPair> read_pairs(const std::string& file)
{
    const std::string bytes = read_file(file, most_bytes);
    CsvReader csv(file, without_byte_order_mark(bytes), CsvReader::Style::list);
    std::vector<KnownPair> pairs;
    std::vector<std::string> fields;
    for (; !csv.at_end(); csv.next_line()) {
        const std::size_t line = csv.line();
        fields.clear();
        for (bool last = false; !last;) fields.emplace_back(csv.next(last));
        if (fields.size() == 1 && fields[0].empty()) continue;
        if (fields.size() < 2 || fields[0].empty() || fields[1].empty())
            refuse(fmt::format("{}: line {}", file, line),
                   "not two names; expected two names or patterns: \"bolt*\",housing");
        if (pairs.empty() && fields.size() > 2 && fields[2] == "status") continue; // the header of a report
        pairs.push_back({fields[0], fields[1], line});
    }
    return pairs;
}

int rank(std::string_view kind)
{
    return kind == "near" ? 0 : kind == "touching" ? 1 : 2;
}

} // namespace

std::string name_in_csv(const std::string& name)
{
    constexpr std::string_view begin_formulas = "=+-@\t\r";
    return !name.empty() && begin_formulas.find(name[0]) != begin_formulas.npos ? "'" + name : name;
}

void ignore_pairs(const std::string& file, const PartList& list, std::vector<Clash>& clashes,
                  std::vector<std::string>& warnings)
{
    // Rows of a report hold names that are no patterns; a backslash in such a name stands for itself.
    const auto fits = [](const std::string& known, const std::string& name) {
        return known == name || known == name_in_csv(name) || matches(known, name);
    };
    for (const KnownPair& known : read_pairs(file)) {
        for (Clash& clash : clashes) {
            const std::string &a = list.parts[clash.a].name, &b = list.parts[clash.b].name;
            if ((fits(known.a, a) && fits(known.b, b)) || (fits(known.a, b) && fits(known.b, a)))
                clash.status = ClashStatus::ignored;
        }
        for (const std::string& name : {known.a, known.b})
            if (std::ranges::none_of(list.parts, [&](const Part& part) { return fits(name, part.name); }))
                warnings.push_back(fmt::format("{}: line {}: no part is named '{}'", file, known.line, name));
    }
}

std::vector<FixedClash> compare_with_baseline(const std::string& file, const PartList& list,
                                              std::vector<Clash>& clashes)
{
    const auto refuse_report = [&](const std::string& why) {
        refuse(file, fmt::format("{}; expected a JSON report of 'oncollide clash'", why));
    };
    std::map<std::pair<std::string, std::string>, std::string> before; // names in order, kind
    try {
        const nlohmann::json report = nlohmann::json::parse(read_file(file, most_bytes));
        if (!report.is_object() || report.value("report", "") != "oncollide clash")
            refuse_report("is not a clash report");
        for (const nlohmann::json& clash : report.at("clashes")) {
            const auto status = clash.at("status").get<std::string>();
            if (status != "new" && status != "same") continue;
            auto a = clash.at("a").at("name").get<std::string>(), b = clash.at("b").at("name").get<std::string>();
            if (b < a) std::swap(a, b);
            before[{a, b}] = clash.at("kind").get<std::string>();
        }
    } catch (const nlohmann::json::exception& fault) {
        refuse_report(fault.what());
    }
    for (Clash& clash : clashes) {
        std::pair<std::string, std::string> names(list.parts[clash.a].name, list.parts[clash.b].name);
        if (names.second < names.first) std::swap(names.first, names.second);
        const auto found = before.find(names);
        if (found == before.end() || clash.status == ClashStatus::ignored) continue;
        if (clash.status == ClashStatus::fresh) {
            if (rank(found->second) < rank(name_of(clash.kind)))
                clash.was = found->second;
            else
                clash.status = ClashStatus::same;
            before.erase(found);
        }
    }
    // A clash that is ignored now is not fixed.
    for (const Clash& clash : clashes) {
        if (clash.status != ClashStatus::ignored) continue;
        const std::string &a = list.parts[clash.a].name, &b = list.parts[clash.b].name;
        before.erase({std::min(a, b), std::max(a, b)});
    }
    std::vector<FixedClash> fixed;
    for (const auto& [names, kind] : before) fixed.push_back({names.first, names.second, kind});
    return fixed;
}

} // namespace oncollide::tools
