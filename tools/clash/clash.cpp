// oncollide clash: finds the parts of an assembly that interfere with each other.
#include <iostream>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/base/threads/parallel.hpp>

#include "clash/clash_pictures.hpp"
#include "clash/report.hpp"
#include "cli/command.hpp"
#include "cli/log.hpp"
#include "cli/outputs.hpp"
#include "cli/progress.hpp"

namespace oncollide::tools {
namespace {

struct ClashOptions {
    std::vector<std::string> inputs, units, groups, out;
    std::string clearance = "0", tolerance = "0", ignore, baseline;
    int list = 20, pictures = 40, threads = 0;
    bool touching = false, quiet = false;
};

using Write = void (*)(OutputFile&, const ClashReport&);

enum class Form { json, csv, junit, page };

Form form_of(const std::string& file)
{
    if (file == "-" || file.ends_with(".json")) return Form::json;
    if (file.ends_with(".csv")) return Form::csv;
    if (file.ends_with(".xml")) return Form::junit;
    if (file.ends_with(".html")) return Form::page;
    usage(
        fmt::format("--out {}: the name must end in .html, .json, .csv or .xml (JUnit), or be '-' for JSON on standard "
                    "output",
                    file));
}

void check_out(const ClashOptions& o, const std::vector<std::string>& inputs)
{
    std::vector<std::pair<const char*, std::string>> files;
    for (const std::string& file : o.out) {
        if (file.empty()) usage("--out: the file name is empty");
        form_of(file);
        files.emplace_back("--out", file);
    }
    std::vector<std::string> all = inputs;
    all.push_back(o.ignore), all.push_back(o.baseline);
    check_files(files, all);
}

void write_reports(const ClashOptions& o, const ClashReport& report)
{
    for (const std::string& name : o.out) {
        OutputFile file(name);
        switch (form_of(name)) {
        case Form::json:
            write_json(file, report);
            break;
        case Form::csv:
            write_csv(file, report);
            break;
        case Form::junit:
            write_junit(file, report);
            break;
        case Form::page:
            write_page(file, report, draw_clashes(report, std::size_t(o.pictures), o.quiet));
            break;
        }
        file.commit();
    }
}

void print(const ClashOptions& o, const ClashReport& report)
{
    log_warnings(report.warnings);
    std::ostream& said = std::ranges::count(o.out, "-") ? std::cerr : std::cout;
    for (const std::string& line : summary(report)) said << printable(line) << "\n";
    if (const std::string table = clash_table(report, std::size_t(o.list)); !table.empty()) said << "\n" << table;
    said.flush();
}

int clash(const ClashOptions& o)
{
    show_reading(o.quiet);
    const Units units(o.units);
    check_range("--list", o.list, 0), check_range("--pictures", o.pictures, 0, 10'000);
    check_range("--threads", o.threads, 0, 1024);
    const ClashSettings settings{.clearance = length_from("--clearance", o.clearance, units.reported()),
                                 .tolerance = length_from("--tolerance", o.tolerance, units.reported()),
                                 .touching = o.touching,
                                 .threads = o.threads};
    const std::vector<std::string> files = files_of(o.inputs);
    check_out(o, files);
    PartList parts = read_parts(files, units, o.groups, o.threads ? o.threads : hardware_threads());
    Clashes found = find_clashes(parts, settings);
    std::vector<std::string> warnings = std::move(parts.warnings);
    if (!o.ignore.empty()) ignore_pairs(o.ignore, parts, found.list, warnings);
    std::vector<FixedClash> fixed;
    if (!o.baseline.empty()) fixed = compare_with_baseline(o.baseline, parts, found.list);
    const ClashReport report{parts,      found,    units.reported(), settings,
                             o.baseline, o.ignore, std::move(fixed), std::move(warnings)};
    if (!o.quiet) print(o, report);
    write_reports(o, report);
    return report.count(ClashStatus::fresh) ? 1 : 0;
}

} // namespace

void add_clash(Arguments app)
{
    Arguments sub = app.add_command("clash", "Find the parts of an assembly that interfere with each other");
    auto o = std::make_shared<ClashOptions>();
    sub.add_option("parts", o->inputs,
                   "part files (OBJ, STL, PLY, OFF; one part per file, in the file's coordinates), glTF, COLLADA or "
                   "3MF assemblies (one part per node that shows a mesh), folders of these")
        .required()
        .type_name("FILES|FOLDER|ASSEMBLY");
    sub.add_option("--units", o->units,
                   "unit of the files and of the report: mm, cm, m or in (default mm). glTF files are in metres; "
                   "COLLADA and 3MF files define their unit. PATTERN=UNIT sets the unit of some files: 'frame*.stl=m' "
                   "(repeatable)")
        .type_name("UNIT")
        .repeatable();
    sub.add_option("--clearance", o->clearance, "parts closer than this also clash: 2mm, 0.1in (default 0)")
        .type_name("LENGTH");
    sub.add_option("--tolerance", o->tolerance,
                   "parts that overlap by no more than this count as touching: the overlap is at most this thick, or "
                   "moving one part by this much separates them (default 0)")
        .type_name("LENGTH");
    sub.add_flag("--touching", o->touching, "parts that only touch also clash, for example bolted faces");
    sub.add_option(
           "--group", o->groups,
           "do not compare parts of the same group: file (parts of a file), node (parts below a node of an assembly), "
           "or a pattern of names, 'bolt*' (repeatable; the first match counts)")
        .type_name("file|node|PATTERN")
        .repeatable();
    sub.add_option("--ignore", o->ignore,
                   "known pairs to ignore: CSV, two names or patterns per row; rows of an earlier .csv report work")
        .type_name("FILE.csv");
    sub.add_option("--baseline", o->baseline,
                   "the JSON report of an earlier run: only new or worse clashes count; fixed clashes are listed")
        .type_name("OLD.json");
    sub.add_option("-o,--out", o->out,
                   "write a report: .html (one page with pictures), .json, .csv or .xml (JUnit); '-': JSON on standard "
                   "output (repeatable)")
        .type_name("FILE")
        .repeatable();
    sub.add_option("--list", o->list, "number of clashes to print, the worst first (default 20)").type_name("N");
    sub.add_option("--pictures", o->pictures,
                   "number of clashes to draw in a page, the worst first (default "
                   "40)")
        .type_name("N");
    sub.add_option("--threads", o->threads,
                   "number of threads; 0: all (default). Does not change the "
                   "result")
        .type_name("N");
    sub.add_flag("--quiet", o->quiet, "print only errors");
    sub.footer(
        "All pairs of parts are decided exactly: enclosed (one inside the other), crossing, touching, near (with\n"
        "--clearance). Parts should be closed surfaces; parts inside a part that is not closed are not found; open\n"
        "parts are listed.\n"
        "Exit codes: 0 no new clash, 1 a new clash, 64 and above: error.\n"
        "Examples:\n"
        "  oncollide clash factory.glb --clearance 2mm -o report.html\n"
        "  oncollide clash parts/ --units mm --group 'bolt*' --ignore known.csv -o clashes.json -o clashes.xml\n"
        "  oncollide clash parts/ --baseline clashes.json -o today.json   # 1 only for new clashes\n"
        "More: docs/clash.md.");
    sub.action([o] { return clash(*o); });
}

} // namespace oncollide::tools
