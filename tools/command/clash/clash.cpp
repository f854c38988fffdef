// oncollide clash: finds the parts of an assembly that interfere with each other.
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

#include "clash/bcf_file.hpp"
#include "clash/clash_pictures.hpp"
#include "clash/clash_view.hpp"
#include "clash/known_pairs.hpp"
#include "clash/matrix.hpp"
#include "clash/parts/file_list.hpp"
#include "clash/report.hpp"
#include "clash/review.hpp"
#include "cli/command.hpp"
#include "cli/log.hpp"
#include "cli/outputs.hpp"
#include "cli/progress.hpp"
#include "cli/standard_output.hpp"
#include "common/zip_bytes.hpp"
#include "convert/converters.hpp"
#include "view/view_page.hpp"

namespace oncollide::tools {
namespace {

struct ClashOptions {
    std::vector<std::string> inputs, units, groups, set_a, set_b, out;
    std::string clearance = "0", tolerance, deflection, ignore, baseline, bcf, bcf_version = "2.1", view, group_by,
                matrix;
    int list = 20, pictures = 40, threads = 0, view_limit = 40, most_parts = int(AssemblyOptions{}.most_parts),
        most_pairs = int(ClashSettings{}.most_pairs);
    bool touching = false, self = false, skip_unreadable = false, strict = false, quiet = false;
};

using Write = void (*)(OutputFile&, const ClashReport&);

enum class Form { json, csv, junit, page, bcf };

Form form_of(const std::string& file)
{
    if (file == "-" || file.ends_with(".json")) return Form::json;
    if (file.ends_with(".csv")) return Form::csv;
    if (file.ends_with(".xml")) return Form::junit;
    if (file.ends_with(".html")) return Form::page;
    if (file.ends_with(".bcf") || file.ends_with(".bcfzip")) return Form::bcf;
    usage(fmt::format("--out {}: the name must end in .html, .json, .csv, .xml (JUnit), .bcf or .bcfzip, or be '-' for "
                      "JSON on standard output",
                      file));
}

BcfVersion bcf_version_from(const std::string& text)
{
    if (text != "2.1" && text != "3.0") usage(fmt::format("--bcf-version {}: expected 2.1 or 3.0", text));
    return text == "2.1" ? BcfVersion::v2_1 : BcfVersion::v3_0;
}

void check_out(const ClashOptions& o, const std::vector<std::string>& inputs)
{
    std::vector<std::pair<const char*, std::string>> files;
    for (const std::string& file : o.out) {
        if (form_of(file) == Form::bcf) check_zip("--out " + file);
        files.emplace_back("--out", file);
    }
    if (!o.bcf.empty()) check_zip("--bcf"), files.emplace_back("--bcf", o.bcf);
    if (!o.view.empty()) files.emplace_back("--view", o.view);
    bcf_version_from(o.bcf_version);
    std::vector<std::string> all = inputs;
    for (const std::string& read : {o.ignore, o.baseline, o.matrix}) all.push_back(read);
    check_files(files, all);
    check_view("--view", o.view, o.view_limit, {}, all);
}

/// The file names with their formats.
std::vector<std::pair<std::string, Form>> reports_of(const ClashOptions& o)
{
    std::vector<std::pair<std::string, Form>> reports;
    for (const std::string& name : o.out) reports.emplace_back(name, form_of(name));
    if (!o.bcf.empty()) reports.emplace_back(o.bcf, Form::bcf);
    return reports;
}

/// `file` in a link on the page `from`. It escapes every byte that has a meaning in a URL.
std::string link_from(const std::string& from, const std::string& file)
{
    namespace fs = std::filesystem;
    const fs::path folder = absolute_path(from).parent_path();
    std::string url;
    for (const char c : portable_name(absolute_path(file).lexically_relative(folder)))
        url +=
            std::isalnum(static_cast<unsigned char>(c)) || std::string_view("-_.~/").find(c) != std::string_view::npos
                ? std::string(1, c)
                : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    return "./" + url;
}

bool has_pictures(const std::pair<std::string, Form>& report)
{
    return report.second == Form::page || report.second == Form::bcf;
}

void write_reports(const ClashOptions& o, ClashReport& report, PainterProcess& painter)
{
    std::optional<ClashPictures> drawn;
    std::string missing_in; // files
    const auto pictures = [&]() -> const ClashPictures& {
        if (!drawn) drawn = draw_clashes(report, painter, std::size_t(o.pictures), o.quiet);
        return *drawn;
    };
    std::vector<std::pair<std::string, Form>> reports = reports_of(o);
    std::ranges::stable_partition(reports, std::not_fn(has_pictures)); // numbers do not wait for pictures
    for (const auto& [name, form] : reports) {
        OutputFile file(name);
        switch (form) {
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
            report.view = o.view.empty() ? "" : link_from(name, o.view);
            write_page(file, report, pictures());
            break;
        case Form::bcf:
            write_bcf(file, report, pictures(), bcf_version_from(o.bcf_version));
            if (!o.quiet && !drawn->failed && !drawn->note.empty())
                log(LogLevel::note, fmt::format("{}: {}", name, drawn->note));
            break;
        }
        file.commit();
        if (has_pictures({name, form}) && drawn->failed) missing_in += (missing_in.empty() ? "" : ", ") + name;
    }
    if (!o.quiet && !missing_in.empty()) log(LogLevel::warning, fmt::format("{}: {}", missing_in, drawn->note));
    if (o.view.empty()) return;
    const std::string summary = write_clash_view(o.view, report, std::size_t(o.view_limit) * 1'000'000);
    if (!o.quiet) log(LogLevel::note, summary);
}

/// The present time, or the time that a build sets for files that must not differ from run to run.
std::int64_t report_time()
{
    const char* const set = std::getenv("SOURCE_DATE_EPOCH");
    std::int64_t seconds = 0;
    if (!set || !*set) return std::time(nullptr);
    const auto [end, error] = std::from_chars(set, set + std::strlen(set), seconds);
    if (error != std::errc() || *end || seconds < 0 || seconds > 253402300799)
        usage(fmt::format("SOURCE_DATE_EPOCH={}: expected the seconds since 1970", set));
    return seconds;
}

void print(const ClashOptions& o, const ClashReport& report)
{
    log_warnings(report.warnings);
    std::string text;
    for (const std::string& line : summary(report)) text += printable(line) + "\n";
    if (const std::string table = clash_table(report, std::size_t(o.list)); !table.empty()) text += "\n" + table;
    write_to_stdout(text, std::ranges::count(o.out, "-") > 0);
    flush_stdout();
}

/// Warns of rules without parts, or refuses them if the rules are strict.
void check_matrix(const ClashMatrix& matrix, const ClashOptions& o, PartList& parts)
{
    const std::vector<std::string> idle = matrix.idle_rules(parts);
    if (idle.empty()) return;
    const std::string text = fmt::format("{}: no parts for {}", o.matrix, listed(idle));
    if (o.strict) throw Error(ErrorKind::bad_data, printable(text));
    parts.warnings.push_back(text);
}

int clash(const ClashOptions& o)
{
    show_reading(o.quiet);
    const Units units(o.units);
    check_range("--list", o.list, 0), check_range("--pictures", o.pictures, 0, 10'000);
    check_range("--threads", o.threads, 0, 1024);
    check_range("--max-parts", o.most_parts, 1), check_range("--max-pairs", o.most_pairs, 1);
    if (o.inputs.empty()) usage("clash: give part files, a folder or an assembly (oncollide clash --help)");
    const std::vector<GroupKey> group_by = group_keys_from(o.group_by);
    std::optional<ClashMatrix> matrix;
    if (!o.matrix.empty()) matrix.emplace(o.matrix, units.reported());
    ClashSettings settings{.clearance = length_from("--clearance", o.clearance, units.reported()),
                           .tolerance = o.tolerance.empty() ? tolerance_of_files
                                                            : length_from("--tolerance", o.tolerance, units.reported()),
                           .touching = o.touching,
                           .self = o.self,
                           .matrix = matrix ? &*matrix : nullptr,
                           .most_pairs = std::uint64_t(o.most_pairs),
                           .threads = o.threads};
    if (!o.deflection.empty()) {
        const double length = length_from("--deflection", o.deflection, units.reported());
        if (!(length > 0)) usage("--deflection: must be above 0");
        read_converted_files(fmt::format("{}mm", length * units.reported().millimetres));
    }
    std::vector<std::string> warnings;
    const std::vector<std::string> files = files_of(o.inputs, &warnings);
    check_out(o, files);
    if (o.set_a.empty() && !o.set_b.empty()) usage("--set-b: needs --set-a");
    const std::int64_t time = report_time();
    const PartRules rules{o.groups, o.set_a, o.set_b, o.inputs, std::size_t(o.most_parts), o.skip_unreadable, o.strict};
    PainterProcess painter;
    PartList parts = read_parts(files, units, rules, threads_of(o.threads));
    if (matrix) check_matrix(*matrix, o, parts);
    mend(parts, settings);
    Clashes found = find_clashes(parts, settings);
    warnings.insert(warnings.end(), parts.warnings.begin(), parts.warnings.end());
    if (!o.ignore.empty()) ignore_pairs(o.ignore, parts, o.strict, found.list, warnings);
    std::vector<ResolvedClash> resolved;
    if (!o.baseline.empty())
        resolved = compare_with_baseline(o.baseline, parts, settings.clearance, units.reported(), found.list, warnings);
    ClashReport report{
        parts, found, units.reported(), settings, o.baseline, o.ignore, std::move(resolved), std::move(warnings), rules,
        time,  "",    group_by};
    if (!o.quiet) print(o, report);
    write_reports(o, report, painter);
    return report.count(ClashStatus::fresh) ? 1 : parts.unreadable.empty() ? 0 : 2;
}

void add_comparing_options(Arguments sub, ClashOptions* o)
{
    sub.add_option(
           "--units UNIT", o->units,
           "unit of the files and of the report: mm, cm, m or in (default mm). glTF files are in metres; COLLADA, 3MF "
           "and CAD files define their unit. PATTERN=UNIT sets the unit of some files: 'frame*.stl=m' (repeatable)")
        .repeatable();
    sub.add_option("--clearance LENGTH", o->clearance,
                   "parts at most this far apart also clash: 2mm, 0.1in (default 0)");
    sub.add_option("--tolerance LENGTH", o->tolerance,
                   "parts touch if they are apart by no more than this, or if their overlap holds no ball of this "
                   "diameter (default: the precision of the files, 2^-19 of the largest coordinate; 0: none, and "
                   "parts are not mended)");
    sub.add_option("--matrix FILE.json", o->matrix,
                   "the clash matrix: clearance, tolerance or skip for pairs of disciplines, classes or storeys; other "
                   "pairs have --clearance and --tolerance");
    sub.add_option(
        "--deflection LENGTH", o->deflection,
        "largest distance between meshes of CAD files and the true surfaces, 0.1mm (default: a thousandth of "
        "each part's size, from 0.01 to 1 mm)");
    sub.add_flag("--touching", o->touching,
                 "parts that only touch, or may do so (within), also clash, for example bolted faces");
    sub.add_flag("--self", o->self,
                 "also name the parts whose triangles meet each other; no clash, and no part of the exit code");
    sub.add_option("--group file|node|PATTERN", o->groups,
                   "do not compare parts of the same group: file (parts of a file), node (parts below a node of an "
                   "assembly), or a pattern of names, 'bolt*' (repeatable; the first match counts)")
        .repeatable();
    sub.add_option("--set-a PATTERN", o->set_a,
                   "compare only the parts that match this pattern (name or path, 'robot/*') with the parts of --set-b "
                   "(repeatable)")
        .repeatable();
    sub.add_option("--set-b PATTERN", o->set_b, "the other set; default: all parts outside --set-a (repeatable)")
        .repeatable();
    sub.add_option("--ignore FILE.csv", o->ignore,
                   "known pairs to ignore: CSV, two names or patterns per row; rows of an earlier .csv report work");
    sub.add_flag(
        "--strict", o->strict,
        "a row of --ignore that matches no pair, or a --group that matches no part, is an error, not a warning");
    sub.add_flag("--skip-unreadable", o->skip_unreadable,
                 "go on without files that cannot be read, each with a warning; the exit code is then 2 at best");
}

void add_report_options(Arguments sub, ClashOptions* o)
{
    sub.add_option("--baseline OLD.json", o->baseline,
                   "the JSON report of an earlier run: only clashes that are new, or of a worse kind, count; resolved "
                   "clashes are listed. "
                   "Comments and statuses that you wrote into it are taken over");
    sub.add_option("-o,--out FILE", o->out,
                   "write a report: .html (one page with pictures), .json, .csv, .xml (JUnit) or .bcfzip (BCF); "
                   "'-': JSON on standard output (repeatable)")
        .repeatable();
    sub.add_option("--bcf FILE.bcfzip", o->bcf,
                   "write the new and active clashes as BCF, one topic per clash with camera, parts and picture");
    sub.add_option("--bcf-version 2.1|3.0", o->bcf_version, "version of BCF files (default 2.1)");
    sub.add_option("--view FILE.html", o->view,
                   "write a page in 3D: all parts, and the list of clashes that flies to each; .html reports link to "
                   "it; needs three.js (Debian: libjs-three)");
    add_view_limit(sub, o->view_limit);
    sub.add_option(
        "--group-by KEYS", o->group_by,
        "show the clashes in groups, for example class,storey: class, storey, discipline (of both parts, from "
        "IFC and other files that have them), part (the part with the most clashes first)");
    sub.add_option("--list N", o->list, "number of clashes to print, the worst first (default 20)");
    sub.add_option("--pictures N", o->pictures,
                   "number of clashes to draw in pages and BCF files, the worst first (default 40)");
    sub.add_option(
        "--max-parts N", o->most_parts,
        "limit on the parts that the instances of a file may make, if it writes fewer itself (default 100000)");
    sub.add_option("--max-pairs N", o->most_pairs,
                   "limit on the pairs of parts whose AABBs overlap; a pair takes about 1 KB (default 2000000)");
    sub.add_option("--threads N", o->threads, "number of threads; 0: all (default). Does not change the result");
    sub.add_flag("--quiet", o->quiet, "print only errors");
}

} // namespace

void add_clash(Arguments app)
{
    Arguments sub = app.add_command("clash", "Find the parts of an assembly that interfere with each other");
    auto o = std::make_shared<ClashOptions>();
    // Not marked as required: CLI11 would then take the word `review` for a file.
    sub.add_option("parts FILES|FOLDER|ASSEMBLY", o->inputs,
                   "part files (OBJ, STL, PLY, OFF; one part per file, in the file's coordinates), glTF, COLLADA, "
                   "3MF, STEP, IGES, BREP or IFC assemblies (one part per node that shows a mesh), one OBJ file (one "
                   "part per object or group), folders of these");
    add_clash_review(sub);
    sub.at_most_one_command(); // words after `review` belong to it
    add_comparing_options(sub, o.get());
    add_report_options(sub, o.get());
    sub.footer(
        "All pairs of parts are decided exactly: duplicate (same geometry, same place), enclosed (one inside\n"
        "the other), crossing, within (below the deflection of CAD files), touching, near (with --clearance).\n"
        "Parts should be closed surfaces; parts inside a part that is not closed are not found; open parts are\n"
        "listed.\n"
        "Exit codes: 0 no new clash, 1 a new clash, 2 no new clash, but files were skipped, 64 and above: error.\n"
        "Examples:\n"
        "  oncollide clash factory.glb --clearance 2mm -o report.html\n"
        "  oncollide clash parts/ --units mm --group 'bolt*' --ignore known.csv -o clashes.json -o clashes.xml\n"
        "  oncollide clash robot.glb cell.glb --set-a 'robot.glb*' -o report.html --view view.html\n"
        "  oncollide clash parts/ --baseline clashes.json -o today.json   # 1 only for new clashes\n"
        "  oncollide clash parts/ --bcf issues.bcfzip\n"
        "More: docs/clash.md.");
    sub.action([o] { return clash(*o); });
}

} // namespace oncollide::tools
