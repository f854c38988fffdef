#include "clash/known_pairs.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/text/csv_reader.hpp>
#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/printable.hpp>

#include "clash/parts/name_pattern.hpp"

namespace oncollide::tools {
namespace {

constexpr std::uintmax_t most_list_bytes = std::uintmax_t(1) << 30;

struct KnownPair {
    std::string a, b;
    std::size_t line;
};

std::vector<KnownPair> read_pairs(const std::string& file)
{
    const std::string bytes = read_file(file, most_list_bytes);
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
        // The row names the columns of a report.
        if (fields.size() > 2 && (fields[2] == "status" || fields[2] == "resolved")) continue;
        pairs.push_back({fields[0], fields[1], line});
    }
    return pairs;
}

} // namespace

void ignore_pairs(const std::string& file, const PartList& list, bool strict, std::vector<Clash>& clashes,
                  std::vector<std::string>& warnings)
{
    // Rows of a report hold names that are not patterns; a backslash in such a name stands for itself.
    const auto fits = [](const std::string& known, const std::string& name) {
        return known == name || csv_text(known) == name || matches(known, name);
    };
    std::vector<std::string> idle;
    for (const KnownPair& known : read_pairs(file)) {
        bool found = false;
        for (Clash& clash : clashes) {
            const std::string &a = list.parts[clash.a].name, &b = list.parts[clash.b].name;
            if ((fits(known.a, a) && fits(known.b, b)) || (fits(known.a, b) && fits(known.b, a)))
                clash.status = ClashStatus::ignored, found = true;
        }
        if (!found) idle.push_back(fmt::format("line {} ('{}' and '{}')", known.line, known.a, known.b));
        for (const std::string& name : {known.a, known.b})
            if (std::ranges::none_of(list.parts, [&](const Part& part) { return fits(name, part.name); }))
                warnings.push_back(fmt::format("{}: line {}: no part is named '{}'", file, known.line, name));
    }
    if (idle.empty()) return;
    const std::string text =
        fmt::format("{}: {} no pair that meets: {}", file,
                    idle.size() == 1 ? "1 row matches" : fmt::format("{} rows match", idle.size()), listed(idle));
    if (strict) throw Error(ErrorKind::bad_data, printable(text));
    warnings.push_back(text);
}

} // namespace oncollide::tools
