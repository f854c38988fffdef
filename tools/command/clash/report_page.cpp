// The report as a single HTML page.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>

#include <fmt/ranges.h>

#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/svg.hpp>
#include <oncollide/runs/report.hpp>

#include "clash/clash_view.hpp"
#include "clash/report.hpp"
#include "clash/report_page_text.hpp"
#include "common/base64.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

constexpr std::size_t first_cards = 10; ///< pictures before the table

void head(OutputFile& file)
{
    file.print("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
               "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
               "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
               "'unsafe-inline'; script-src 'unsafe-inline'\">\n"
               "<title>Clash report</title>\n<style>{}</style></head>\n<body>\n<h1>Clash report</h1>\n",
               clash_page_style);
}

std::string kind_text(const Clash& c)
{
    const auto note = [](const std::string& text) {
        return " <span class=\"soft\">(" + xml_escaped(text) + ")</span>";
    };
    return fmt::format("<span class=\"kind {0}\">{0}</span>{1}{2}", name_of(c.kind),
                       c.was.empty() ? "" : note("was " + c.was), c.review.empty() ? "" : note(c.review));
}

/// A link to the clash on the 3D page; empty without such a page.
std::string link_text(const ClashReport& r, const Clash& c)
{
    return r.view.empty() ? "" : fmt::format("<a target=\"clash-3d\" href=\"{}#{}\">3D</a>", r.view, view_of(c));
}

/// The options of the run, in words.
void write_settings(OutputFile& file, const ClashReport& r)
{
    file.print("<h2>Settings</h2>\n<dl>\n");
    const auto row = [&](std::string_view name, const std::string& value) {
        if (!value.empty()) file.print("<dt>{}</dt><dd>{}</dd>\n", name, xml_escaped(value));
    };
    const auto list = [](const std::vector<std::string>& texts, std::size_t most) {
        const std::size_t shown = std::min(most, texts.size());
        std::string text = fmt::format("{}", fmt::join(texts.begin(), texts.begin() + std::ptrdiff_t(shown), ", "));
        return shown < texts.size() ? fmt::format("{} and {} more", text, texts.size() - shown) : text;
    };
    row("Date", time_text(r.time));
    row("Input", list(r.rules.inputs.empty() ? r.parts.files : r.rules.inputs, 20));
    row("Unit", std::string(r.unit.name));
    if (r.parts.deflection() > 0) row("Deflection", r.length(r.parts.deflection()));
    row("Clearance", r.length(r.settings.clearance));
    row("Tolerance", r.length(r.settings.tolerance));
    row("Touching", r.settings.touching ? "a clash" : "no clash");
    row("Groups", list(r.rules.groups, 20));
    row("Set A", list(r.rules.set_a, 20));
    row("Set B", r.rules.set_b.empty() && r.parts.has_sets ? "all other parts" : list(r.rules.set_b, 20));
    row("Known pairs", r.ignore);
    row("Baseline", r.baseline);
    row("oncollide", std::string(version));
    file.print("</dl>\n");
}

/// The property of both parts, for filters: "Wall\nBeam", or "Wall" if they agree.
std::string both(GroupKey key, const ClashReport& r, const Clash& c)
{
    const std::string a = text_of(key, r.parts.parts[c.a]), b = text_of(key, r.parts.parts[c.b]);
    return xml_escaped(a == b ? a : a + "\n" + b);
}

/// @param rows    in Clashes::list
/// @param number  of the last row
void write_rows(OutputFile& file, const ClashReport& r, const std::vector<std::size_t>& rows, std::size_t& number)
{
    for (const std::size_t i : rows) {
        const Clash& c = r.found.list[i];
        const double key = c.apart() ? -c.lower : c.severity();
        const bool open = c.status == ClashStatus::fresh || c.status == ClashStatus::active;
        file.print("<tr id=\"{}\"", c.id);
        if (open)
            file.print(" data-status=\"{}\" data-kind=\"{}\" data-classes=\"{}\" data-storeys=\"{}\" "
                       "data-disciplines=\"{}\" data-size=\"{}\"",
                       xml_escaped(c.status_text()), name_of(c.kind), both(GroupKey::part_class, r, c),
                       both(GroupKey::storey, r, c), both(GroupKey::discipline, r, c), std::abs(key));
        file.print("><td class=\"number\" data-key=\"{0}\">{0}</td><td>{1}</td><td data-key=\"{2}\">{3}</td>", ++number,
                   kind_text(c), key, xml_escaped(measure_text(r, c)));
        for (const std::uint32_t part : {c.a, c.b})
            file.print("<td title=\"{}\">{}</td>", xml_escaped(r.parts.parts[part].path),
                       xml_escaped(shortened(r.label(part), 80)));
        file.print("<td class=\"number\">{} {}</td><td>{}</td><td>{}</td></tr>\n", r.position(c.where), link_text(r, c),
                   xml_escaped(c.status_text()), xml_escaped(c.comment));
    }
}

void write_table(OutputFile& file, const ClashReport& r, const std::vector<ClashGroup>& groups)
{
    const char* headings[] = {"#", "kind", "overlap or gap", "part", "part", "where", "status", "comment"};
    file.print("<div class=\"scroll\"><table><thead><tr>");
    for (const char* heading : headings) file.print("<th scope=\"col\"><button>{}</button></th>", heading);
    file.print("</tr></thead>\n");
    std::size_t number = 0;
    for (const ClashGroup& group : groups) {
        file.print("<tbody>\n");
        if (!group.name.empty())
            file.print("<tr class=\"group\"><th colspan=\"8\" scope=\"rowgroup\">{} ({})</th></tr>\n",
                       xml_escaped(group.name), grouped(group.rows.size()));
        write_rows(file, r, group.rows, number);
        file.print("</tbody>\n");
    }
    file.print("</table></div>\n");
}

/// The pictures of some clashes.
void write_cards(OutputFile& file, const ClashReport& r, const ClashPictures& pictures,
                 std::span<const std::size_t> rows)
{
    bool any = false;
    for (const std::size_t i : rows) {
        const Clash& c = r.found.list[i];
        if (i >= pictures.images.size() || pictures.images[i].empty()) continue;
        if (!any) file.print("<div class=\"cards\">\n");
        any = true;
        const std::string a = xml_escaped(r.label(c.a)), b = xml_escaped(r.label(c.b));
        file.print("<figure data-id=\"{}\"><img alt=\"{} and {}, {}: close-up, and as a whole\" loading=\"lazy\" "
                   "width=\"720\" height=\"360\" src=\"data:image/png;base64,",
                   c.id, a, b, name_of(c.kind));
        file.write(base64(pictures.images[i]));
        file.print("\"><figcaption>{} <b>{}</b> and <b>{}</b>: {}, at {} {} <a href=\"#{}\">row</a></figcaption>"
                   "</figure>\n",
                   kind_text(c), a, b, xml_escaped(measure_text(r, c)), r.position(c.where), link_text(r, c), c.id);
    }
    if (any) file.print("</div>\n");
}

void write_section(OutputFile& file, const ClashReport& r, const ClashPictures& pictures, ClashStatus status,
                   std::string_view title)
{
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < r.found.list.size(); ++i)
        if (r.found.list[i].status == status) rows.push_back(i);
    if (rows.empty()) return;
    file.print("<h2>{} ({})</h2>\n", title, grouped(rows.size()));
    const bool open = status == ClashStatus::fresh || status == ClashStatus::active;
    write_table(file, r, groups_of(r.parts, r.found.list, rows, open ? r.group_by : std::vector<GroupKey>{}));
    write_cards(file, r, pictures,
                std::span(rows).subspan(open && status == ClashStatus::fresh ? std::min(rows.size(), first_cards) : 0));
}

/// How many open clashes there are between parts of each two disciplines, or, within one discipline, classes.
void write_matrix(OutputFile& file, const ClashReport& r)
{
    const auto of = [&](GroupKey key) {
        std::set<std::string> names;
        for (const Part& part : r.parts.parts) names.insert(text_of(key, part));
        return names;
    };
    const GroupKey key = of(GroupKey::discipline).size() > 1 ? GroupKey::discipline : GroupKey::part_class;
    if (of(key).size() < 2) return;
    std::map<std::pair<std::string, std::string>, std::size_t> counts;
    std::set<std::string> names;
    for (const std::size_t i : r.open_clashes()) {
        std::string a = text_of(key, r.parts.parts[r.found.list[i].a]),
                    b = text_of(key, r.parts.parts[r.found.list[i].b]);
        if (b < a) std::swap(a, b);
        names.insert({a, b}), ++counts[{a, b}];
    }
    if (names.empty()) return;
    file.print("<h2>By {}</h2>\n<div class=\"scroll\"><table class=\"matrix\"><thead><tr><th></th>", name_of(key));
    for (const std::string& name : names) file.print("<th scope=\"col\">{}</th>", xml_escaped(name));
    file.print("</tr></thead><tbody>\n");
    for (const std::string& a : names) {
        file.print("<tr><th scope=\"row\">{}</th>", xml_escaped(a));
        for (const std::string& b : names) {
            const auto at = counts.find({std::min(a, b), std::max(a, b)});
            file.print("<td>{}</td>", at == counts.end() ? "" : grouped(at->second));
        }
        file.print("</tr>\n");
    }
    file.print("</tbody></table></div>\n");
}

/// The JSON report, for the page's script. `<` is escaped, so that no name ends the element.
void write_data(OutputFile& file, const ClashReport& r)
{
    TextInMemory json;
    write_json(json, r);
    std::string text;
    for (const char c : json.text())
        if (c == '<')
            text += "\\u003c";
        else
            text += c;
    file.print("<script type=\"application/json\" id=\"report\">");
    file.write(text);
    file.print("</script>\n");
}

} // namespace

void write_page(OutputFile& file, const ClashReport& r, const ClashPictures& pictures)
{
    head(file);
    for (const std::string& line : summary(r)) file.print("<p>{}</p>\n", xml_escaped(line));
    if (!pictures.note.empty()) file.print("<p class=\"soft\">{}</p>\n", xml_escaped(pictures.note));
    constexpr std::size_t shown_warnings = 3;
    for (std::size_t i = 0; i < r.warnings.size(); ++i) {
        if (i == shown_warnings)
            file.print("<details><summary>{} more warnings</summary>\n", r.warnings.size() - shown_warnings);
        file.print("<p class=\"warning\">{}</p>\n", xml_escaped(r.warnings[i]));
    }
    if (r.warnings.size() > shown_warnings) file.print("</details>\n");
    write_matrix(file, r);
    std::vector<std::size_t> worst;
    for (std::size_t i = 0; i < r.found.list.size() && worst.size() < first_cards; ++i)
        if (r.found.list[i].status == ClashStatus::fresh) worst.push_back(i);
    const bool drawn = std::ranges::any_of(
        worst, [&](std::size_t i) { return i < pictures.images.size() && !pictures.images[i].empty(); });
    if (drawn) file.print("<h2>The worst</h2>\n");
    write_cards(file, r, pictures, worst);
    file.print("<div class=\"filters\" id=\"filters\" hidden></div>\n");
    write_section(file, r, pictures, ClashStatus::fresh, r.baseline.empty() ? "Clashes" : "New clashes");
    write_section(file, r, pictures, ClashStatus::active, "Active clashes, also in the baseline");
    if (!r.resolved.empty()) {
        file.print("<h2>Resolved since the baseline ({})</h2>\n<ul>\n", grouped(r.resolved.size()));
        for (const ResolvedClash& c : r.resolved)
            file.print("<li>{} and {} ({}){}</li>\n", xml_escaped(c.a), xml_escaped(c.b), xml_escaped(c.kind),
                       c.comment.empty() ? "" : ": " + xml_escaped(c.comment));
        file.print("</ul>\n");
    }
    write_section(file, r, pictures, ClashStatus::contact, "Pairs that only touch, or may do so (not a clash)");
    write_section(file, r, pictures, ClashStatus::ignored, "Ignored pairs");
    write_settings(file, r);
    file.print("<p class=\"soft\">Every pair was decided exactly. Overlap: a ball of at least this diameter fits into "
               "the common "
               "part of both parts. Lengths and positions in {}.{}</p>\n",
               r.unit.name,
               r.count(ClashStatus::fresh) + r.count(ClashStatus::active)
                   ? " Pictures: the first part is blue, the second yellow, both transparent; their common part, or an "
                     "enclosed part, is red. Left: close-up; right: both parts as a whole."
                   : "");
    write_data(file, r);
    file.print("<script>{}</script>\n</body></html>\n", clash_page_script);
}

} // namespace oncollide::tools
