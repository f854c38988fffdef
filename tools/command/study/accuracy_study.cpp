// oncollide accuracy study, and oncollide-lab study: time against error of a scene, with other libraries for
// comparison, as a table and a page.
#include "cli/command.hpp"
#include "cli/lengths.hpp"
#include "cli/log.hpp"
#include "cli/shard.hpp"
#include "cli/standard_output.hpp"
#include "cli/system.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/pipeline/result_hash.hpp>

#include "common/page_parts.hpp"
#include "common/text.hpp"
#include "render/backend_trial.hpp"
#include "study/play.hpp"
#include "study/report.hpp"
#include "study/study_command.hpp"

namespace oncollide::tools {
namespace {

struct StudyOptions {
    WorkloadOptions workload;
    SettingsOptions settings;
    std::string depths, max_errors, backends = "cpu", bounding_volumes = "sphere,obb", exact = "off,predicates";
    std::string viewports = "16", peers, html, svg, csv, json, shard;
    int warm_up = 3, repeats = 3;
    std::string called; ///< the command, as one types it
    std::vector<PeerKind> known_peers;
};

/// The numbers of a list, in its order.
std::vector<int> parse_list(const char* option, const std::string& list, const char* form)
{
    std::vector<int> numbers;
    for (const std::string& part : split(list)) {
        int value = 0;
        const auto [rest, error] = std::from_chars(part.data(), part.data() + part.size(), value);
        if (error != std::errc{} || rest != part.data() + part.size())
            usage(fmt::format("{} {}: '{}' is not a number; expected a list such as {}", option, list, part, form));
        numbers.push_back(value);
    }
    return numbers;
}

/// Rounded to two significant digits, so that names are short.
double two_digits(double value)
{
    return std::stod(fmt::format("{:.1e}", value));
}

/// One setting of the accuracy: a depth or a maximum error.
struct Dial {
    std::optional<int> depth;
    std::optional<double> max_error;
    std::string text() const { return depth ? fmt::format("depth {}", *depth) : fmt::format("{} m", *max_error); }
};

/// @param size  median diagonal of the bodies' boxes, m: the errors are parts of it unless the options list them
std::vector<Dial> dials_of(const StudyOptions& o, double size)
{
    constexpr int default_percents[] = {50, 20, 10, 5, 2, 1};
    if (!(size > 0 && std::isfinite(size))) size = 1; // half-spaces
    if (!o.depths.empty() && !o.max_errors.empty())
        usage("--depths and --max-errors: give only one of them; both set the accuracy");
    std::vector<Dial> dials;
    if (!o.max_errors.empty())
        for (const std::string& error : split(o.max_errors))
            dials.push_back({{}, length_from("--max-errors", error, unit_from("", "m"))});
    else if (!o.depths.empty())
        for (int depth : parse_depths("--depths", o.depths)) dials.push_back({depth, {}});
    else
        for (int percent : default_percents) dials.push_back({{}, two_digits(0.01 * percent * size)});
    return dials;
}

/// A source of cells: a backend by name; gl-query once per viewport.
struct Source {
    std::string prefix; ///< of variant names; empty for the cpu
    SettingsOptions settings;
};

std::vector<Source> sources_of(const StudyOptions& o)
{
    std::vector<Source> sources;
    for (const std::string& backend : split(o.backends)) {
        Source source{backend == "cpu" ? "" : backend + ", ", o.settings};
        source.settings["backend"].text = backend;
        if (backend_from_name(backend) != BackendKind::gl_query) {
            sources.push_back(source);
            continue;
        }
        for (int viewport : parse_list("--viewport", o.viewports, "8,16,64")) {
            source.prefix = fmt::format("{} {} px, ", backend, viewport), source.settings["viewport"].whole = viewport;
            sources.push_back(source);
        }
    }
    return sources;
}

/// All distinct combinations: a GPU only finds spheres, and an exact result has no accuracy setting.
std::vector<StudyVariant> variants_of(const StudyOptions& o, double size)
{
    std::vector<StudyVariant> variants;
    const std::vector<Dial> dials = dials_of(o, size);
    for (const Source& source : sources_of(o))
        for (const std::string& volume : split(o.bounding_volumes))
            for (const std::string& exact : split(o.exact)) {
                SettingsOptions one = source.settings;
                one["bounding_volume"].text = volume, one["exact"].text = exact;
                // Without an exact level, touching pairs cannot be recognised and are left over as false positives.
                if (exact_from_name(exact) == ExactLevel::off)
                    one["contact_kinds"].flag = one["ignore_touching"].flag = false;
                const BoundingVolume kind = bounding_volume_from_name(volume);
                if (kind == BoundingVolume::automatic)
                    usage("--bounding-volume auto: a study needs a definite choice; expected sphere, obb or both");
                if (kind == BoundingVolume::obb && !source.prefix.empty()) continue;
                const std::string form = kind == BoundingVolume::obb ? "OBBs" : "spheres";
                if (exact_from_name(exact) != ExactLevel::off) {
                    const std::string name = fmt::format("{}{}, {}", source.prefix, form, exact);
                    variants.push_back({name, name, with_tried_backend(settings_from(one))});
                    continue;
                }
                for (const Dial& dial : dials) {
                    one["depth"].whole = dial.depth, one["max_error"].number = dial.max_error;
                    const std::string series = source.prefix + form;
                    variants.push_back(
                        {series, fmt::format("{}, {}", series, dial.text()), with_tried_backend(settings_from(one))});
                }
            }
    if (o.settings["ignore_touching"].flag &&
        std::ranges::none_of(variants, [](const StudyVariant& v) { return v.settings.ignore_touching; }))
        usage("--ignore-touching: needs --exact predicates in the list");
    if (variants.empty()) usage("--bounding-volume obb: OBBs need --backend cpu; no variant is left");
    return variants;
}

/// The settings that all variants share.
Settings common_of(const std::vector<StudyVariant>& variants)
{
    Settings settings = variants.front().settings;
    settings.bounding_volume = BoundingVolume::automatic;
    return settings;
}

template <class Write>
void write_file(const std::string& path, Write write)
{
    if (path.empty()) return;
    OutputFile file(path);
    write(file);
    file.commit();
}

/// ", FCL, ODE"; empty: none.
std::string names_of(const std::vector<StudyPeer>& peers)
{
    std::string names;
    for (const StudyPeer& peer : peers) names += ", " + peer.name;
    return names;
}

/// Throws Error{usage} for one mesh alone.
void check_what(const std::string& called, const std::vector<std::string>& what)
{
    if (what.size() != 1) return;
    constexpr std::array<std::string_view, 4> meshes{".obj", ".stl", ".ply", ".off"};
    if (std::ranges::find(meshes, lower_extension(what[0])) != meshes.end())
        usage(fmt::format("{0} {1}: takes a scene (a file, or a name of 'oncollide scene --list'), or two meshes, the "
                          "second in many poses around the first: {0} {1} OTHER",
                          called, what[0]));
}

int accuracy_study(const StudyOptions& o)
{
    check_what(o.called, o.workload.what);
    check_range("--repeats", o.repeats, 1, 1000), check_range("--warm-up", o.warm_up, 0);
    const std::vector<StudyVariant> planned = variants_of(o, 1); // refuses wrong options before anything is read
    const std::size_t all = planned.size();
    std::optional<PainterProcess> painter;
    if (!o.html.empty()) painter.emplace(planned.front().settings.gpu);
    std::vector<PeerKind> peers = peers_from_names(o.known_peers, o.peers);
    const Shard shard = shard_from(o.shard);
    check_parts(shard, all, "variants");
    if (shard.part < shard.parts) peers.clear(); // their rows are the last ones
    std::vector<std::string> inputs = o.workload.what;
    inputs.push_back(o.workload.poses);
    check_files({{"--html", o.html}, {"--svg", o.svg}, {"--csv", o.csv}, {"--json", o.json}}, inputs);
    check_extension("--svg", o.svg, {".svg"}, svg_to_pdf);
    StudyWorkload workload(o.workload);
    print_warnings(workload.scene);
    std::vector<StudyVariant> variants = variants_of(o, median_size(workload.scene));
    keep_part(shard, variants, "variants");
    const Study study = play_study(workload, variants, peers, {.warm_up = o.warm_up, .repeats = o.repeats});
    const std::string about = fmt::format(
        "workload   {}; {} frames, {} of them to warm up, least of {} {}; all variants{} in alternation\n"
        "truth      exact integers on the triangles of all pairs of bodies whose AABBs overlap, long double for "
        "distances;\n"
        "           extended precision on convex sets for shapes and maps\n"
        "settings   {}\n{}",
        printable(study.title), study.frames, study.warm_up, o.repeats, o.repeats == 1 ? "run" : "runs",
        names_of(study.peers),
        describe(common_of(variants), "accuracy, exact level and bounding volume by variant", false),
        describe_program(study.rows.front().backend));
    say("{}{} bodies of {} triangles, {:.3g} m median; {} collisions in all frames\n\n", about, grouped(study.bodies),
        grouped(study.triangles), study.size, grouped(study.colliding));
    for (const std::string& note : study.left_out) say("left out   {}\n", note);
    print_study(study);
    flush_stdout();
    write_file(o.csv, [&](OutputFile& file) {
        file.write(shard.line(fmt::format("accuracy study, {}; {} variants, {} frames, warm-up {}, settings {:016x}",
                                          printable(study.title), all, study.frames, study.warm_up,
                                          hash_of(settings_from(o.settings)))));
        write_study_csv(file, study);
    });
    write_file(o.json, [&](OutputFile& file) { write_study_json(file, study, about); });
    write_file(o.svg, [&](OutputFile& file) { draw_speed_error(file, study); });
    write_file(o.html, [&](OutputFile& file) {
        const StudyPictures pictures = draw_study_pictures(workload, study, *painter);
        if (!pictures.missing.empty()) log(LogLevel::warning, fmt::format("{}: {}", o.html, pictures.missing));
        write_study_page(file, study, pictures, command_text(), about);
    });
    return study.faulty() ? int(ErrorKind::internal) : 0;
}

std::string peers_help(const std::vector<PeerKind>& known)
{
    std::vector<std::string> names, by_default;
    for (const PeerKind& kind : known) {
        names.push_back(kind.name);
        if (kind.by_default) by_default.push_back(kind.name);
    }
    return fmt::format("other libraries: comma-separated list of {}, or all, or none (default {})",
                       fmt::join(names, ", "), fmt::join(by_default, ","));
}

/// Adds the options. Returns the option that takes poses from a file.
Option add_study_options(Arguments sub, StudyOptions& o)
{
    sub.add_option("what SCENE.json|NAME|MESH_A MESH_B", o.workload.what, "a scene, or two mesh files");
    const Option poses =
        sub.add_option("--poses FILE", o.workload.poses,
                       "two meshes in the poses of this file; without a file and meshes: the data folder's set")
            .expected(0, 1);
    sub.add_option("--distances LIST", o.workload.distances,
                   "two meshes: distances of generated poses, in percent of A's diagonal (default 0,0.1,1,5)");
    sub.add_option("--count N", o.workload.count,
                   "two meshes: poses per distance (default 100), or poses of the file (default all)");
    sub.add_option("--every N", o.workload.every, "process only every N-th frame or pose");
    sub.add_option("--depths LIST", o.depths, "instead of errors: depths of the trees, such as 2-8");
    sub.add_option("--max-errors LIST", o.max_errors,
                   "errors in metres or with a unit, such as 0.1,0.03,1cm (default: 50, 20, 10, 5, 2 and 1 % of the "
                   "bodies' median size)");
    sub.add_option("--backend LIST", o.backends, "comma-separated list of cpu, gl-compute, gl-query (default cpu)");
    sub.add_option("--viewport LIST", o.viewports, "gl-query: pixels per side, comma-separated (default 16)");
    sub.add_option("--bounding-volume LIST", o.bounding_volumes, "sphere, obb or both (default sphere,obb)");
    sub.add_option("--exact LIST", o.exact, "exact levels: off, predicates, fcl (default off,predicates)");
    sub.add_option("--peers LIST", o.peers, peers_help(o.known_peers));
    sub.add_option("--warm-up N", o.warm_up, "frames at the start that are not timed (default 3)");
    sub.add_option(
        "--repeats N", o.repeats,
        "number of runs; each frame's least time counts. A scene starts anew, poses reuse the grown trees (default 3)");
    sub.add_option("--html FILE", o.html, "write a page with all results, figures and pictures; needs no network");
    sub.add_option("--svg FILE", o.svg, "write the figure of time against error, for a paper");
    sub.add_option("--csv FILE", o.csv, "write one row per variant");
    sub.add_option("--shard I/N", o.shard, std::string("divide the variants among N processes: ") + shard_help);
    sub.add_option("--json FILE", o.json, "write the same as JSON, with times per stage");
    return poses;
}

} // namespace

void add_accuracy_study(Arguments accuracy)
{
    add_study(accuracy, "oncollide accuracy study", {fcl_peer()});
}

void add_study(Arguments parent, const std::string& called, std::vector<PeerKind> peers)
{
    Arguments sub = parent.add_command(
        "study", "Measure time against error: a scene, or two meshes in many poses, with many settings and other "
                 "libraries");
    auto options = std::make_shared<StudyOptions>();
    options->called = called, options->known_peers = std::move(peers);
    add_catalogue_options(sub, options->workload.scene);
    add_accuracy_options(sub, options->settings);
    add_pipeline_options(sub, options->settings);
    for (const char* replaced : {"--depth", "--max-error", "--exact", "--backend", "--viewport", "--bounding-volume"})
        sub.remove_option(replaced);
    const Option poses = add_study_options(sub, *options);
    sub.footer(fmt::format(
        "The truth is exact arithmetic on the triangles of all pairs of bodies whose AABBs overlap, without any tree,\n"
        "traversal or predicate of the library. Columns:\n"
        "  error     the largest certified bound of a pair left over: no such pair is farther apart\n"
        "  x FCL     speed relative to FCL, from mean times\n"
        "  left over pairs that are not certified separate; false: pairs left over that are apart\n"
        "  missed    collisions not found: must be 0, except for gl-query, which certifies nothing\n"
        "  at m      true distance of the false positives: median and largest\n"
        "  needed    share of the fully grown trees' cells and boxes that tests ever reached\n\n"
        "Examples:\n"
        "  {0} many --frames 20 --html many.html\n"
        "  {0} a.obj b.obj --poses poses.txt --max-errors 0.1,0.01,0.001 --csv study.csv\n"
        "  {0} many --bodies 200 --frames 5 --peers all --csv peers.csv\n"
        "  {0} many --frames 20 --svg many.svg\n"
        "  rsvg-convert -f pdf -o many.pdf many.svg    # Debian: librsvg2-bin\n"
        "  {0} paper --backend cpu,gl-query --viewport 8,64 --bounding-volume sphere\n"
        "Exit code 70: a certified result was wrong.",
        called));
    sub.action([options, poses] {
        options->workload.use_poses = poses.given();
        return accuracy_study(*options);
    });
}

} // namespace oncollide::tools
