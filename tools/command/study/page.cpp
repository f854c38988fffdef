#include "common/page_parts.hpp"
#include "study/report.hpp"

#include <algorithm>

#include <oncollide/base/text/svg.hpp>

#include "common/text.hpp"

namespace oncollide::tools {
namespace {

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
    if (!pictures.missing.empty()) paragraph(file, pictures.missing);
    if (pictures.all.empty()) return pictures.missing.empty() ? paragraph(file, "There were none.") : void();
    paragraph(file, "Left: both bodies; right: their nearest points. Red spheres, the darkest in print, touched "
                    "spheres of the other body; bodies separated by OBBs are shown without spheres.");
    for (const PagePicture& picture : pictures.all) show_picture(file, picture);
}

} // namespace

void write_study_page(OutputFile& file, const Study& study, const StudyPictures& pictures, const std::string& command,
                      const std::string& about)
{
    begin_page(file, study.title + ": speed against error", command);
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
    end_page(file, about);
}

} // namespace oncollide::tools
