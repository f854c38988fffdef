// oncollide accuracy continuous: sweeps of a scene against checks of sampled poses, as a table and a page.
#include "cli/command.hpp"
#include "cli/system.hpp"
#include "common/line_plot.hpp"
#include "common/numbers.hpp"
#include "common/page_parts.hpp"
#include "common/text.hpp"
#include "study/continuous/continuous_study.hpp"

#include <algorithm>
#include <functional>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/base/text/svg.hpp>
#include <oncollide/narrowphase/fcl/exact_fcl.hpp>

namespace oncollide::tools {
namespace {

struct ContinuousCommand {
    WorkloadOptions workload;
    std::string scene, tolerances = "1e-2,1e-3,1e-4,1e-6", samples = "1,10,100,1000", html, svg, csv, json;
    int count = 1000, of_fcl = 50;
};

ContinuousOptions options_from(const ContinuousCommand& o)
{
    ContinuousOptions options;
    check_range("--count", o.count, 1, 1'000'000), check_range("--fcl", o.of_fcl, 0);
    options.count = std::size_t(o.count), options.of_fcl = fcl_available() ? std::size_t(o.of_fcl) : 0;
    options.tolerances.clear();
    for (const std::string& part : split(o.tolerances)) {
        const double value = parse_numbers("--tolerances", part, 1, "1e-4,1e-6")[0];
        if (!(value >= 1e-12 && value <= 1))
            usage(fmt::format("--tolerances {}: {} must be from 1e-12 to 1", o.tolerances, part));
        options.tolerances.push_back(value);
    }
    std::ranges::sort(options.tolerances, std::greater());
    options.samples.clear();
    for (const std::size_t count : parse_counts("--poses", o.samples, 1'000'000)) options.samples.push_back(int(count));
    return options;
}

void print_table(const ContinuousStudy& study)
{
    say("{:<11}{:<28}{:>9}{:>10}{:>8}{:>10}{:>12}{:>13}{:>12}\n", "", "", "steps", "contacts", "missed", "invented",
        "latest", "median, us", "mean, us");
    for (const ContinuousRow& row : study.rows)
        say("{:<11}{:<28}{:>9}{:>10}{:>8}{:>10}{:>12.3g}{:>13.4g}{:>12.4g}\n", row.name, row.setting, row.us.size(),
            row.contacts, row.missed, row.invented, row.latest, median(row.us), mean(row.us));
}

void write_csv(const std::string& path, const ContinuousStudy& study)
{
    CsvFile csv(path, "contender,setting,share,steps,contacts,missed,invented,latest,median_us,mean_us");
    for (const ContinuousRow& row : study.rows)
        csv.row(row.name, Quoted{row.setting}, row.share, row.us.size(), row.contacts, row.missed, row.invented,
                row.latest, Digits{median(row.us), 4}, Digits{mean(row.us), 4});
    csv.commit();
}

void write_json(OutputFile& file, const ContinuousStudy& study)
{
    JsonWriter json(file);
    json.begin_object(), json.schema("oncollide.accuracy_continuous", 1);
    json.key("header"), json.object("version", version, "scene", study.title, "bodies", study.bodies, "frames",
                                    study.frames, "steps", study.steps, "studied", study.pairs.size(), "contacts",
                                    study.contacts, "open", study.open, "contradicted", study.contradicted);
    json.key("rows"), json.begin_array();
    for (const ContinuousRow& row : study.rows) {
        json.line(2);
        json.object("contender", row.name, "setting", row.setting, "share", row.share, "steps", row.us.size(),
                    "contacts", row.contacts, "missed", row.missed, "invented", row.invented, "latest", row.latest,
                    "median_us", median(row.us), "mean_us", mean(row.us));
    }
    json.line(), json.end_array(), json.end_object();
    file.write("\n");
}

void draw_speeds(OutputFile& file, const ContinuousStudy& study)
{
    PlotPanel panel{study.title + ": time of a step against its tolerance", {}};
    for (const ContinuousRow& row : study.rows) {
        if (row.us.empty()) continue;
        const bool ours = row.name == "oncollide", sampled = row.name == "sampled";
        const std::string label = ours || sampled ? row.name : row.name + ", " + row.setting;
        if (panel.lines.empty() || panel.lines.back().label != label)
            panel.lines.push_back(
                {ours ? PlotLine::Weight::main : PlotLine::Weight::peer, label, {}, panel.lines.size()});
        panel.lines.back().points.push_back({row.share, mean(row.us)});
    }
    for (PlotLine& line : panel.lines) std::ranges::sort(line.points, {}, &PlotLine::Point::x);
    draw_line_plot(file, {&panel, 1},
                   {.x_label = "tolerance, or time between two sampled poses; share of the step (logarithmic)",
                    .y_label = "microseconds, mean (logarithmic)",
                    .value_text = [](double us) { return fmt::format("{:.3g} us", us); }});
}

std::string summary(const ContinuousStudy& study)
{
    return fmt::format(
        "{} bodies, {} frames: {} steps of pairs that come near each other and are apart at the start; {} "
        "of them studied, {} with a contact on the way, {} too close to call.",
        grouped(study.bodies), grouped(std::size_t(study.frames)), grouped(study.steps), grouped(study.pairs.size()),
        grouped(study.contacts), grouped(study.open));
}

constexpr std::string_view without_contacts =
    "No pair meets on its way, so nothing could be missed: this scene compares times only. Scenes of the catalogue "
    "with contacts: octomap, campus, many.";

void write_page(OutputFile& file, const Scene& scene, const ContinuousStudy& study, const std::string& about)
{
    begin_page(file, study.title + ": contacts on the way", command_text());
    paragraph(file, summary(study));
    if (study.contacts == 0) fault(file, without_contacts);
    if (study.contradicted)
        fault(file, fmt::format("FAULT: in {} steps, a pose collides before the certified time.", study.contradicted));
    file.print("<figure>");
    draw_speeds(file, study);
    file.print("</figure>\n<div class=\"scroll\"><table>\n<thead><tr><th>contender</th><th>setting</th><th>steps</th>"
               "<th>contacts</th><th>missed</th><th>invented</th><th>latest, share of the step</th><th>us, median</th>"
               "<th>us, mean</th></tr></thead>\n<tbody>\n");
    for (const ContinuousRow& row : study.rows)
        file.print("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.3g}</td>"
                   "<td>{:.4g}</td><td>{:.4g}</td></tr>\n",
                   row.name, xml_escaped(row.setting), row.us.size(), row.contacts, row.missed, row.invented,
                   row.latest, median(row.us), mean(row.us));
    file.print("</tbody>\n</table></div>\n");
    paragraph(file,
              "Missed: a pose of contact is known by exact tests, and the contender finds none in the step. "
              "Invented: the whole step is certified free, and the contender finds a contact. Latest: the largest "
              "time from a contact to the one found. Sampled poses are tested exactly, until one collides. FCL "
              "takes steps of two meshes.");
    heading(file, "The worst miss");
    if (const std::optional<PagePicture> picture = draw_worst_miss(scene, study))
        show_picture(file, *picture);
    else
        paragraph(file, study.contacts ? "Sampled poses missed no contact." : "There was none to miss.");
    end_page(file, about);
}

int accuracy_continuous(ContinuousCommand o)
{
    const ContinuousOptions options = options_from(o);
    check_files({{"--html", o.html}, {"--svg", o.svg}, {"--csv", o.csv}, {"--json", o.json}}, {o.scene});
    check_extension("--svg", o.svg, {".svg"}, svg_to_pdf);
    o.workload.what = {o.scene};
    StudyWorkload workload(o.workload);
    print_warnings(workload.scene);
    if (workload.frames() < 2)
        usage(fmt::format("accuracy continuous: {}: its bodies move from frame to frame; at least 2 frames are needed",
                          workload.title));
    const ContinuousStudy study = play_continuous(workload, options);
    const std::string about = describe_program("cpu");
    say("{}\n{}\n\n", about, summary(study));
    print_table(study);
    if (study.contacts == 0) say("\n{}\n", without_contacts);
    if (study.contradicted) say("\n{} STEPS CONTRADICTED by sampled poses\n", study.contradicted);
    const auto write = [](const std::string& path, auto content) {
        if (path.empty()) return;
        OutputFile file(path);
        content(file);
        file.commit();
    };
    if (!o.csv.empty()) write_csv(o.csv, study);
    write(o.json, [&](OutputFile& file) { write_json(file, study); });
    write(o.svg, [&](OutputFile& file) { draw_speeds(file, study); });
    write(o.html, [&](OutputFile& file) { write_page(file, workload.scene, study, about); });
    return study.contradicted ? int(ErrorKind::internal) : 0;
}

} // namespace

void add_accuracy_continuous(Arguments accuracy)
{
    Arguments sub =
        accuracy.add_command("continuous", "Compare contacts on the way with checks of sampled poses and FCL");
    auto options = std::make_shared<ContinuousCommand>();
    sub.add_option("scene SCENE.json|NAME", options->scene, "scene file, or a name from 'oncollide scene --list'")
        .required();
    sub.add_option("--tolerances LIST", options->tolerances,
                   "of the time, and of the distance in median sizes of the bodies (default 1e-2,1e-3,1e-4,1e-6)");
    sub.add_option("--poses LIST", options->samples, "numbers of sampled poses in a step (default 1,10,100,1000)");
    sub.add_option("--count N", options->count, "steps of pairs to study (default 1000)");
    sub.add_option("--fcl N", options->of_fcl, "of these, steps of two meshes that FCL takes, too (default 50)");
    sub.add_option("--every N", options->workload.every, "process only every N-th frame");
    add_catalogue_options(sub, options->workload.scene);
    sub.add_option("--html FILE", options->html, "write a page with a figure and a picture of the worst miss");
    sub.add_option("--svg FILE", options->svg,
                   "write the figure, for a paper; 'rsvg-convert -f pdf -o x.pdf x.svg' makes PDF (Debian: "
                   "librsvg2-bin)");
    sub.add_option("--csv FILE", options->csv, "write one row per contender and setting");
    sub.add_option("--json FILE", options->json, "write the same as JSON");
    sub.footer("Bodies move in a straight line from frame to frame, and rotate along the shorter arc. Pairs in contact "
               "at the start of a step are left out. Exit code 70: a sampled pose collides before a certified time.");
    sub.action([options] { return accuracy_continuous(*options); });
}

} // namespace oncollide::tools
