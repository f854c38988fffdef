#include "study/report.hpp"

#include <algorithm>

#include <oncollide/base/text/svg.hpp>

#include "common/base64.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

constexpr std::string_view style = R"(
body { font: 15px/1.5 "DejaVu Sans", Verdana, Helvetica, Arial, sans-serif; color: #222; background: #fff;
       max-width: 1000px; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.6em; } h2 { font-size: 1.2em; margin-top: 2em; }
table { border-collapse: collapse; font-size: 12px; margin: 1em 0; } th, td { padding: 3px 6px; text-align: right; }
td { border-bottom: 1px solid #ddd; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; } thead th { border-bottom: 2px solid #444; vertical-align: bottom; }
.scroll { overflow-x: auto; } .fault { font-weight: bold; border: 2px solid #222; padding: 4px 8px; }
svg { max-width: 100%; height: auto; } img { max-width: 100%; border: 1px solid #bbb; }
figure { margin: 1em 0; } figcaption { font-size: 13px; } pre { font-size: 11px; white-space: pre-wrap; }
.bar { fill: #0072b2; } .band { fill: #f4f4f4; } .head { font-weight: bold; } .name { font-size: 11px; }
.number { font-size: 11px; }
@media print { body { margin: 0; max-width: none; font-size: 10pt; } .scroll { overflow: visible; }
  table { font-size: 6pt; } th, td { padding: 1px 2px; } h2 { break-after: avoid; } figure, svg, tr { break-inside: avoid; }
  .bar { fill: #555; } }
)";

void heading(OutputFile& file, std::string_view words)
{
    file.print("<h2>{}</h2>\n", xml_escaped(words));
}

void paragraph(OutputFile& file, std::string_view words)
{
    file.print("<p>{}</p>\n", xml_escaped(words));
}

void fault(OutputFile& file, std::string_view words)
{
    file.print("<p class=\"fault\">{}</p>\n", xml_escaped(words));
}

void write_errors_of_peers(OutputFile& file, const Study& study)
{
    std::string all, errors;
    for (const StudyPeer& peer : study.peers) {
        all += fmt::format("{} missed {} collisions and invented {}. ", peer.name, peer.missed, peer.invented);
        for (const std::string& error : peer.errors)
            errors += fmt::format("<li>{}</li>\n", xml_escaped(fmt::format("{}, {}", peer.name, error)));
    }
    if (!all.empty()) paragraph(file, all);
    if (!errors.empty()) file.print("<ul>\n{}</ul>\n", errors);
}

void write_summary(OutputFile& file, const Study& study)
{
    std::uint64_t missed = 0, lost = 0, broken = 0, invented = 0;
    for (const StudyRow& row : study.rows) {
        (row.variant.certified() ? missed : lost) += row.missed;
        broken += row.broken, invented += row.wrong;
    }
    paragraph(file, fmt::format("{} bodies, {} frames, {} collisions. The median size of a body is {:.3g} m.",
                                grouped(study.bodies), grouped(std::uint64_t(study.frames)), grouped(study.colliding),
                                study.size));
    if (study.faulty())
        fault(file, fmt::format("FAULT: {} collisions missed, {} invented, {} bounds broken, {} results in the pose "
                                "file contradicted.",
                                missed, invented, broken, study.contradicted));
    else
        paragraph(file, "No variant that certifies its results missed or invented a collision, and every "
                        "false positive lies within its bound.");
    if (lost) fault(file, fmt::format("gl-query, which certifies nothing, missed {} collisions.", lost));
    write_errors_of_peers(file, study);
    for (const std::string& note : study.left_out) paragraph(file, "Skipped: " + note);
}

/// Two tables: a single one would not fit on a page.
void write_tables(OutputFile& file, const Study& study)
{
    file.print("<div class=\"scroll\"><table>\n<thead><tr><th>variant</th><th>error, m</th><th>% of size</th>"
               "<th>ms, mean</th><th>ms, median</th><th>times FCL</th><th>within</th><th>undecided</th>"
               "<th>colliding</th><th>missed</th><th>false positives</th></tr></thead>\n<tbody>\n");
    for (const StudyRow& row : study.rows)
        file.print("<tr><td>{}{}</td><td>{}</td><td>{:.3g}</td><td>{:.4g}</td><td>{:.4g}</td><td>{}</td><td>{}</td>"
                   "<td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                   xml_escaped(row.variant.name), on_front(study, row) ? " ★" : "", error_text(row),
                   100 * row.error / study.size, study.mean_ms(row.ms), study.median_ms(row.ms),
                   ratio_text(study, row.ms), row.verdicts[std::size_t(Verdict::within)],
                   row.verdicts[std::size_t(Verdict::undecided)], row.verdicts[std::size_t(Verdict::colliding)],
                   row.missed, row.false_positives);
    for (const StudyPeer& peer : study.peers)
        file.print("<tr><td>{}{}</td><td>0</td><td>0</td><td>{:.4g}</td><td>{:.4g}</td><td>{}</td><td></td><td></td>"
                   "<td>{}</td><td>{}</td><td>{}</td></tr>\n",
                   peer.name, on_front(study, peer) ? " ★" : "", study.mean_ms(peer.ms), study.median_ms(peer.ms),
                   ratio_text(study, peer.ms), peer.colliding, peer.missed, peer.invented);
    file.print("</tbody>\n</table></div>\n<div class=\"scroll\"><table>\n<thead><tr><th>variant</th>"
               "<th>tests of spheres or boxes</th><th>tests of triangles</th><th>MB of trees</th>"
               "<th>share of the full trees reached (needed)</th><th>distance of false positives, m (median)</th>"
               "<th>at most, m</th></tr></thead>\n<tbody>\n");
    const std::uint64_t n = std::uint64_t(study.frames);
    for (const StudyRow& row : study.rows)
        file.print(
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{:.3f}</td><td>{}</td><td>{:.3g}</td><td>{:.3g}</td></tr>\n",
            xml_escaped(row.variant.name), mean_text(row.trees.node_pairs, n), mean_text(row.trees.triangle_pairs, n),
            double(row.trees.bytes) / 1e6, needed_text(row), false_positive_quantile(row, 0.5),
            false_positive_quantile(row, 1));
    for (const StudyPeer& peer : study.peers)
        file.print("<tr><td>{}</td><td></td><td></td><td>{:.3f}</td><td></td><td></td><td></td></tr>\n", peer.name,
                   double(peer.bytes) / 1e6);
    file.print("</tbody>\n</table></div>\n");
}

void write_pictures(OutputFile& file, const StudyPictures& pictures)
{
    heading(file, "The worst false positives, and missed collisions");
    if (!pictures.none.empty()) return paragraph(file, "No pictures: " + pictures.none);
    if (pictures.all.empty()) return paragraph(file, "There were none.");
    paragraph(file, "Left: both bodies; right: their nearest points. Red spheres, the darkest in print, touched "
                    "spheres of the other body; bodies separated by OBBs are shown without spheres.");
    for (const StudyPicture& picture : pictures.all)
        file.print(
            "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"/><figcaption>{0}</figcaption></figure>\n",
            xml_escaped(picture.caption), base64(picture.png));
}

} // namespace

void write_study_page(OutputFile& file, const Study& study, const StudyPictures& pictures, const std::string& command,
                      const std::string& about)
{
    file.print("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><title>{}: speed against "
               "error</title>\n<style>{}</style></head>\n<body>\n<h1>{}: speed against error</h1>\n",
               xml_escaped(study.title), style, xml_escaped(study.title));
    if (!command.empty()) file.print("<pre>{}</pre>\n", xml_escaped(command));
    write_summary(file, study);
    file.print("<figure>");
    draw_speed_error(file, study);
    file.print("</figure>\n");
    paragraph(file,
              "Error is the largest certified bound of a pair that was not ruled out (left over): no such pair is "
              "farther apart. Other libraries and the exact levels are at the left edge. A row with ★ is the fastest "
              "at its error: no other row is at least as exact and as fast. A library with an error does not count as "
              "exact.");
    write_tables(file, study);
    paragraph(
        file,
        "Verdicts, missed collisions and false positives are counted over all frames; tests are means per frame. "
        "Missed: the bodies collide by exact arithmetic, but were reported separate. False positives: not ruled out, "
        "but apart; between meshes their true distance is bounded in long double. Needed: the share of the fully grown "
        "trees' cells and boxes that a test ever reached.");
    heading(file, "Time by stage, ms per frame");
    draw_stage_times(file, study);
    heading(file, "Pairs left by each stage, per frame (bars logarithmic)");
    draw_funnel(file, study);
    heading(file, "True distance of the false positives, in percent of their bound");
    if (std::ranges::any_of(study.rows, &StudyRow::false_positives))
        draw_false_positives(file, study);
    else
        paragraph(file, "There were no false positives.");
    write_pictures(file, pictures);
    heading(file, "Measurement");
    file.print("<pre>");
    for (std::size_t at = 0; at < about.size();) {
        const std::size_t end = std::min(about.find('\n', at), about.size());
        file.print("{}\n", xml_escaped(about.substr(at, end - at)));
        at = end + 1;
    }
    file.print("</pre>\n</body></html>\n");
}

} // namespace oncollide::tools
