// The report as a single HTML page.
#include <algorithm>

#include <fmt/ranges.h>

#include <oncollide/base/text/svg.hpp>
#include <oncollide/runs/report.hpp>

#include "clash/report.hpp"
#include "common/base64.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

constexpr std::string_view style = R"(
:root { color-scheme: light dark; --ink: #1d232b; --paper: #ffffff; --soft: #5b6673; --line: #d4dae1; --band: #f3f5f8;
        --enclosed: #8e1b63; --crossing: #b3261e; --touching: #8a5a00; --near: #1f5fa8; --duplicate: #5b2a86; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e9ee; --paper: #15191f; --soft: #9aa6b4; --line: #343c47;
        --band: #1e242c; --enclosed: #f08cc8; --crossing: #ff8a80; --touching: #e9b44c; --near: #7fb8f5; --duplicate: #c9a2f0; } }
body { font: 15px/1.5 "DejaVu Sans", Verdana, Helvetica, Arial, sans-serif; color: var(--ink); background: var(--paper);
       max-width: 1120px; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.6em; margin-bottom: 0.2em; } h2 { font-size: 1.2em; margin-top: 2em; }
p { margin: 0.3em 0; } .soft { color: var(--soft); } .warning { border-left: 4px solid var(--touching); padding-left: 0.6em; }
.scroll { overflow-x: auto; } table { border-collapse: collapse; font-size: 13px; width: 100%; }
th, td { padding: 4px 8px; text-align: left; border-bottom: 1px solid var(--line); overflow-wrap: anywhere; }
thead th { border-bottom: 2px solid var(--soft); white-space: nowrap; } th button { all: unset; cursor: pointer; }
th button:focus-visible { outline: 2px solid var(--near); } th button::after { content: " \2195"; color: var(--soft); }
.number { text-align: right; white-space: nowrap; }
.enclosed { color: var(--enclosed); } .crossing { color: var(--crossing); } .touching { color: var(--touching); }
.near { color: var(--near); } .duplicate { color: var(--duplicate); } .kind { font-weight: bold; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 0.1em 1em; font-size: 13px; } dd { margin: 0; overflow-wrap: anywhere; }
a { color: var(--near); } tr:target, figure:target { outline: 2px solid var(--near); }
.cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 480px), 1fr)); gap: 1.2em; }
figure { margin: 0; border: 1px solid var(--line); border-radius: 6px; background: var(--band); overflow: hidden; }
figure img { width: 100%; height: auto; display: block; } figcaption { padding: 0.5em 0.8em; font-size: 13px; overflow-wrap: anywhere; }
@media print { body { margin: 0; max-width: none; font-size: 10pt; } figure, tr { break-inside: avoid; } }
)";

/// Sorts a table by the rows' keys when its heading is clicked. The page is readable without scripts.
constexpr std::string_view script = R"(
for (const button of document.querySelectorAll("th button")) button.addEventListener("click", () => {
  const head = button.parentElement, column = head.cellIndex, body = head.closest("table").tBodies[0];
  const up = head.getAttribute("aria-sort") !== "ascending";
  for (const other of head.parentElement.cells) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", up ? "ascending" : "descending");
  const key = row => { const cell = row.cells[column], key = cell.dataset.key; return key === undefined ? cell.textContent : +key; };
  const rows = [...body.rows].sort((a, b) => { const p = key(a), q = key(b);
    return (typeof p === "number" ? p - q : p.localeCompare(q, undefined, {numeric: true})) * (up ? 1 : -1); });
  body.append(...rows);
});
)";

void head(OutputFile& file)
{
    file.print("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
               "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
               "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
               "'unsafe-inline'; script-src 'unsafe-inline'\">\n"
               "<title>Clash report</title>\n<style>{}</style></head>\n<body>\n<h1>Clash report</h1>\n",
               style);
}

std::string kind_text(const Clash& c)
{
    const auto note = [](const std::string& text) {
        return " <span class=\"soft\">(" + xml_escaped(text) + ")</span>";
    };
    return fmt::format("<span class=\"kind {0}\">{0}</span>{1}{2}", name_of(c.kind),
                       c.was.empty() ? "" : note("was " + c.was), c.review.empty() ? "" : note(c.review));
}

/// A link into the 3D page that shows the pair from near; empty without such a page.
std::string link_text(const ClashReport& r, const Clash& c, const ClashView& view)
{
    if (r.view.empty()) return "";
    const auto& [from, middle, radius] = view;
    const std::string at = fmt::format("{:.9g},{:.9g},{:.9g},{:.4g},{:.3g},{:.3g},{:.3g}", middle.x(), middle.y(),
                                       middle.z(), radius, from.x(), from.y(), from.z());
    return fmt::format("<a target=\"clash-3d\" href=\"{}#pair={},{}&amp;isolate&amp;at={}\">3D</a>", r.view, c.a, c.b,
                       at);
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

void write_table(OutputFile& file, const ClashReport& r, const ClashPictures& pictures, ClashStatus status)
{
    const char* headings[] = {"", "kind", "overlap or gap", "part", "part", "where", "comment"};
    file.print("<div class=\"scroll\"><table><thead><tr>");
    for (const char* heading : headings)
        file.print("<th scope=\"col\"><button>{}</button></th>", *heading ? heading : "#");
    file.print("</tr></thead><tbody>\n");
    std::size_t row = 0;
    for (std::size_t i = 0; i < r.found.list.size(); ++i) {
        const Clash& c = r.found.list[i];
        if (c.status != status) continue;
        const double key = c.apart() ? -c.lower : c.severity();
        file.print(
            "<tr id=\"{4}\"><td class=\"number\" data-key=\"{0}\">{0}</td><td>{1}</td><td data-key=\"{2}\">{3}</td>",
            ++row, kind_text(c), key, xml_escaped(measure_text(r, c)), c.id);
        const auto part = [&](std::uint32_t number) {
            return fmt::format("<td title=\"{}\">{}</td>", xml_escaped(r.parts.parts[number].path),
                               xml_escaped(r.name(number)));
        };
        file.print("{}{}<td class=\"number\">{} {}</td><td>{}</td></tr>\n", part(c.a), part(c.b), point_text(c.where),
                   link_text(r, c, pictures.views[i]), xml_escaped(c.comment));
    }
    file.print("</tbody></table></div>\n");
}

void write_cards(OutputFile& file, const ClashReport& r, const ClashPictures& pictures, ClashStatus status)
{
    bool any = false;
    std::size_t row = 0;
    for (std::size_t i = 0; i < r.found.list.size(); ++i) {
        const Clash& c = r.found.list[i];
        row += c.status == status;
        if (c.status != status || i >= pictures.images.size() || pictures.images[i].empty()) continue;
        if (!any) file.print("<div class=\"cards\">\n");
        any = true;
        const std::string a = xml_escaped(r.name(c.a)), b = xml_escaped(r.name(c.b));
        file.print("<figure><img alt=\"{} and {}, {}: close-up, and as a whole\" loading=\"lazy\" width=\"720\" "
                   "height=\"360\" src=\"data:image/png;base64,",
                   a, b, name_of(c.kind));
        file.write(base64(pictures.images[i]));
        file.print("\"><figcaption>{}. {} <b>{}</b> and <b>{}</b>: {}, at {} {}</figcaption></figure>\n", row,
                   kind_text(c), a, b, xml_escaped(measure_text(r, c)), point_text(c.where),
                   link_text(r, c, pictures.views[i]));
    }
    if (any) file.print("</div>\n");
}

void write_section(OutputFile& file, const ClashReport& r, const ClashPictures& pictures, ClashStatus status,
                   std::string_view title)
{
    const std::size_t count = r.count(status);
    if (count == 0) return;
    file.print("<h2>{} ({})</h2>\n", title, grouped(count));
    write_cards(file, r, pictures, status);
    write_table(file, r, pictures, status);
}

} // namespace

void write_page(OutputFile& file, const ClashReport& r, const ClashPictures& pictures)
{
    head(file);
    for (const std::string& line : summary(r)) file.print("<p>{}</p>\n", xml_escaped(line));
    file.print(
        "<p class=\"soft\">Every pair was decided exactly. Overlap: the common part of both parts is at most this "
        "thick, and a vertex of one is at least this deep inside the other. Lengths and positions in {}.{}</p>\n",
        r.unit.name,
        r.count(ClashStatus::fresh) + r.count(ClashStatus::active)
            ? " Pictures: the first part is blue, the second yellow, both transparent; their common part, or an "
              "enclosed part, is red. Left: close-up; right: both parts as a whole."
            : "");
    if (!pictures.note.empty()) file.print("<p class=\"soft\">{}</p>\n", xml_escaped(pictures.note));
    for (const std::string& warning : r.warnings) file.print("<p class=\"warning\">{}</p>\n", xml_escaped(warning));
    write_settings(file, r);
    write_section(file, r, pictures, ClashStatus::fresh, r.baseline.empty() ? "Clashes" : "New clashes");
    write_section(file, r, pictures, ClashStatus::active, "Active clashes, also in the baseline");
    if (!r.resolved.empty()) {
        file.print("<h2>Resolved since the baseline ({})</h2>\n<ul>\n", grouped(r.resolved.size()));
        for (const ResolvedClash& c : r.resolved)
            file.print("<li>{} and {} ({}){}</li>\n", xml_escaped(c.a), xml_escaped(c.b), xml_escaped(c.kind),
                       c.comment.empty() ? "" : ": " + xml_escaped(c.comment));
        file.print("</ul>\n");
    }
    write_section(file, r, pictures, ClashStatus::contact, "Pairs that only touch (not a clash)");
    write_section(file, r, pictures, ClashStatus::ignored, "Ignored pairs");
    file.print("<script>{}</script>\n</body></html>\n", script);
}

} // namespace oncollide::tools
