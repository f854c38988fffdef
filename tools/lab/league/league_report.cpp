#include "league/league_report.hpp"

#include <algorithm>
#include <ctime>
#include <filesystem>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/number_text.hpp>

#include "common/text.hpp"
#include "league/page_text.hpp"
#include "view/page_file.hpp"

namespace oncollide::tools {
namespace {

using nlohmann::json;

std::uint64_t total(const LeagueCell& cell)
{
    return cell.wrong() + cell.crashed + cell.hung;
}

/// The table as JSON, with the worst cases as bodies.
json json_of_table(const LeagueTable& table)
{
    std::uint64_t cases = 0;
    json out{{"schema", "oncollide.league"},
             {"schema_version", 1},
             {"program", fmt::format("oncollide {}", version)},
             {"date", fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::time(nullptr)))}};
    for (const LeagueEntry& entry : table.libraries) {
        const league_library& l = *entry.library;
        out["libraries"].push_back({{"name", l.name},
                                    {"settings", l.settings},
                                    {"source", l.source},
                                    {"bits", l.bits},
                                    {"conservative", l.conservative != 0},
                                    {"precision", l.precision},
                                    {"adapter", entry.given ? entry.adapter : ""}});
    }
    for (std::size_t f = 0; f < table.families.size(); ++f) {
        const LeagueFamily& family = table.families[f];
        out["families"].push_back({{"name", family.name},
                                   {"group", family.group},
                                   {"question", name_of(family.question)},
                                   {"what", family.what}});
        for (std::size_t e = 0; e < table.libraries.size(); ++e) {
            const LeagueCell& cell = table.cells[f][e];
            cases += cell.answered();
            json result = cell.json();
            result["library"] = table.libraries[e].library->name, result["family"] = family.name;
            for (json& worst : result["worst"]) {
                LeagueCase asked = family.make(worst["seed"]);
                if (table.libraries[e].library->bits == 32) asked = rounded_to_float(std::move(asked));
                worst["case"] = json_of(AskedCase(std::move(asked)).view());
            }
            out["results"].push_back(std::move(result));
        }
    }
    out["cases"] = cases;
    return out;
}

void write_csv(const std::string& path, const LeagueTable& table)
{
    OutputFile file(path);
    file.print("family,question,library,cases,undecided,unsupported,failed,crashed,hung");
    for (const std::string_view name : fault_names) file.print(",{}", name);
    file.print(",ns\n");
    for (std::size_t f = 0; f < table.families.size(); ++f)
        for (std::size_t e = 0; e < table.libraries.size(); ++e) {
            const LeagueCell& c = table.cells[f][e];
            file.print("\"{}\",{},{},{},{},{},{},{},{}", table.families[f].name, name_of(table.families[f].question),
                       table.libraries[e].library->name, c.cases, c.open, c.unsupported, c.failed, c.crashed, c.hung);
            for (const std::uint64_t count : c.faults) file.print(",{}", count);
            file.print(",{:.1f}\n", c.answered() ? c.nanoseconds / double(c.answered()) : 0);
        }
    file.commit();
}

} // namespace

LeagueCell LeagueTable::sum(std::size_t library) const
{
    LeagueCell sum;
    for (const auto& row : cells) sum.add(row[library]);
    return sum;
}

std::uint64_t LeagueTable::wrong_of(std::string_view library) const
{
    for (std::size_t e = 0; e < libraries.size(); ++e)
        if (libraries[e].library->name == library) return total(sum(e));
    return 0;
}

std::string text_of(const LeagueTable& table)
{
    std::string text =
        fmt::format("{:<18}{:>10}{:>12}{:>9}{:>9}{:>10}{:>8}{:>10}{:>12}  {}\n", "library", "answers", "right, %",
                    "missed", "invented", "inexact", "extra", "no answer", "us a query", "settings");
    for (std::size_t e = 0; e < table.libraries.size(); ++e) {
        const LeagueCell c = table.sum(e);
        const auto of = [&](LeagueFault fault) { return c.faults[std::size_t(fault)]; };
        const std::uint64_t missed = of(LeagueFault::missed) + of(LeagueFault::late),
                            invented = of(LeagueFault::invented) + of(LeagueFault::early);
        text += fmt::format("{:<18}{:>10}{:>12.4f}{:>9}{:>9}{:>10}{:>8}{:>10}{:>12.3g}  {}\n",
                            table.libraries[e].library->name, grouped(c.answered()),
                            c.cases > c.unsupported ? 100 * double(c.right()) / double(c.cases - c.unsupported) : 0,
                            grouped(missed), grouped(invented), grouped(c.wrong() - missed - invented),
                            grouped(c.extra()), grouped(c.failed + c.crashed + c.hung),
                            c.answered() ? 1e-3 * c.nanoseconds / double(c.answered()) : 0,
                            table.libraries[e].library->settings);
    }
    std::size_t longest = 0; // name of a family
    for (const LeagueFamily& family : table.families) longest = std::max(longest, family.name.size());
    text += "\nwrong answers\n";
    for (std::size_t f = 0; f < table.families.size(); ++f) {
        text += fmt::format("{:<{}}", table.families[f].name, longest);
        for (std::size_t e = 0; e < table.libraries.size(); ++e) {
            const LeagueCell& c = table.cells[f][e];
            text += fmt::format(" {:>8}", c.answered() + c.crashed + c.hung == 0 ? "-" : grouped(total(c)));
        }
        text += "\n";
    }
    return text;
}

void write_reports(const std::string& folder, const LeagueTable& table)
{
    const json all = json_of_table(table);
    const auto path = [&](const char* name) { return (std::filesystem::path(folder) / name).string(); };
    OutputFile data(path("league.json"));
    data.write(all.dump(-1, ' ', true, json::error_handler_t::replace) + "\n");
    data.commit();
    write_csv(path("league.csv"), table);
    OutputFile page(path("league.html"));
    PageFile out(page, league_page::league_html);
    out.until("{{title}}"), out.write("League");
    out.until("{{style}}"), out.write(league_page::league_css);
    out.until("{{data}}"), out.add_json("league", all);
    out.until("{{script}}"), out.write(league_page::league_js), out.finish();
    page.commit();
}

} // namespace oncollide::tools
